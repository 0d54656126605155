"""An experiment as one would tell it: measure at two loads, look, identify. Run it with Python; it takes seconds."""

from pathlib import Path

from bench import campaign, connect, steady

bench = connect("rh380n")  # or the path of your own bench file; bus="eth1" for hardware
sweep = campaign("my-sweep", steady(load_torques=(0.0, 400.0), speeds_deg_s=(10.0, -10.0, 20.0, -20.0)))
print(f"{bench.plan(sweep).duration_s / 60:.1f} min of bench time")

recordings = bench.run(sweep, "my-sweep")  # an interrupted run goes on where it was
for data in recordings:  # one xarray.Dataset each, in SI units
    error = data.transmission_error.where(data.segment == "steady")
    rms = 1e6 * float(error.std())
    print(f"{data.set_load_torque:4.0f} N·m {data.set_velocity:+.2f} rad/s: transmission error {rms:.1f} µrad RMS")

model = recordings.identify(1, 3, 4, 12, 46, 92)  # these orders; identify() takes the paper's
model.save(Path("my-model.json"))
report = recordings.find_mismatch("my-report", model)
print(f"{report.verdict}: {', '.join(finding.name for finding in report.findings) or report.why}")
