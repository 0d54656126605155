"""An experiment as one would tell it: measure at two loads, look, identify. Run it with Python; it takes seconds."""

from math import radians
from pathlib import Path

import numpy as np

from bench.campaigns import Block, Campaign, Stage, make_plan
from bench.campaigns.session import run_campaign
from bench.configuration import load_bench
from bench.identification import Options, identify_folder, to_simulation
from bench.recording import RecordingFolder

bench = load_bench("rh380n")  # or the path of your own bench file
speeds = tuple(radians(v) for v in (10, -10, 20, -20))
sweep = Block("constant_velocity", load_torques=(0.0, 400.0), velocities=speeds)
campaign = Campaign("my-sweep", "two loads, two speeds, both directions", (Stage("sweep", (sweep,)),))
print(f"{make_plan(campaign, bench.configuration).duration_s / 60:.1f} min of bench time")

folder = Path("my-sweep")
run_campaign(bench, campaign, folder)  # an interrupted run goes on where it was

for recording in RecordingFolder.open(folder).recordings:
    (steady,) = recording.steady()
    angles = recording.read_si(["motor_angle", "load_angle"], steady.start, steady.stop)
    error = angles["load_angle"] - angles["motor_angle"] / recording.gearbox.ratio
    at = recording.setpoint
    print(f"{at.load_torque:4.0f} N·m {at.velocity:+.2f} rad/s: transmission error {1e6 * np.std(error):.1f} µrad RMS")

found = identify_folder(folder, Options(orders=(1, 3, 4, 12, 46, 92)))
to_simulation(found, "refined").save(Path("my-model.json"))
