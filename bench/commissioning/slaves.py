"""Steps without motion: who is on the bus, what the drives keep of their limits, the safety circuits, the tare."""

from __future__ import annotations

from bench.commissioning.torque_zero import torque_zero
from bench.commissioning.trial import Trial
from bench.cycle.assembly import device_errors
from bench.devices import ObjectDictionary, SafetyInputs
from bench.errors import DeviceError

DRIVES = ("input_drive", "load_drive")
_OBJECTS = {"6072:00": "u2", "6080:00": "u4", "6065:00": "u4", "605A:00": "i2", "605E:00": "i2", "6085:00": "u4"}
"""What is read back of a drive for the record: torque, speed, following error, quick stop, fault reaction, ramp."""
_IDENTITY = {"vendor": "1018:01", "product": "1018:02", "revision": "1018:03", "serial": "1018:04"}
_TARE_S = 1.0
_PATIENCE_S = 60.0


def identities(trial: Trial) -> str:
    """Ask every slave who it is (0x1018); the bus has refused any other order when it was opened.

    A slave without an object dictionary cannot be asked: nothing stands in the record for it.

    Raises
    ------
    DeviceError
        If one says that it is another.
    """
    bus = trial.rig.link.assembly.bus
    talks = {spec.name: spec.coe for spec in bus.specs}
    silent = []
    with device_errors():
        for slave in trial.bench.bus.slaves:
            if not talks[slave.role]:
                silent.append(slave.role)
                trial.values[slave.role] = None
                continue
            seen = {name: _read(bus.sdo(slave.role), entry, "u4") for name, entry in _IDENTITY.items()}
            trial.values[slave.role] = seen
            if (seen["vendor"], seen["product"]) != (slave.vendor, slave.product):
                raise DeviceError(
                    f"{slave.role} says that it is {seen['vendor']:08X} {seen['product']:08X}, the bench file has"
                    f" {slave.vendor:08X} {slave.product:08X}"
                )
    unasked = f"; not asked, for want of an object dictionary: {', '.join(silent)}" if silent else ""
    return f"{len(talks) - len(silent)} slaves say that they are those of the bench file{unasked}"


def limits(trial: Trial) -> str:
    """Read the drives' own limits again, long after they were written, and compare.

    Raises
    ------
    DeviceError
        If a drive does not keep one.
    """
    assembly = trial.rig.link.assembly
    with device_errors():
        for role, drive in zip(DRIVES, (assembly.input_drive, assembly.load_drive), strict=True):
            sdo = assembly.bus.sdo(role)
            lost = drive.verify(sdo)
            if lost:
                raise DeviceError("; ".join(lost))
            trial.values[role] = {name: _read(sdo, name, kind) for name, kind in _OBJECTS.items()}
    # the watchdogs' registers are read back and compared where they are written, when the bus is configured
    return "torque, speed, following error, quick stop and fault reaction of both drives read back as written"


def safety_circuits(trial: Trial) -> str:
    """Look at the emergency stop and safe torque off inputs; with a person, press the one and see it open.

    Raises
    ------
    DeviceError
        If a circuit is open, or does not open when the emergency stop is pressed.
    """
    safety = trial.rig.link.assembly.safety
    if safety is None or "emergency_stop" not in safety.names:
        return "the bench has no emergency stop input: software does not see it, hardware must act all the same"
    verdict = trial.rig.look()
    if verdict.tripped:
        raise DeviceError(f"before commissioning everything must be well: {verdict.text}")
    if not trial.guide.has_hands:
        return "both circuits are closed (nobody pressed the emergency stop: an emulated plant)"
    for pressed, wish in ((True, "Press the emergency stop now."), (False, "Release it and reset the safety relay.")):
        trial.guide.show(wish)
        _wait(trial, safety, pressed)
    trial.rig.reset_faults()
    return "the emergency stop opens its circuit and closes it again"


def tare(trial: Trial) -> str:
    """Take the torque sensor's zero at rest without load; refuses a dead, saturated, moving or loaded sensor."""
    counts = trial.watch(_TARE_S).raw("load_torque", steady=False)
    taken = torque_zero(trial.bench, trial.rig.link.assembly.torque_terminal.volt_per_count, counts)
    trial.values.update(zero_nm=taken.zero, deviation_nm=taken.deviation)
    return f"the unloaded torque sensor reads {taken.zero:.3g} N·m"


def _wait(trial: Trial, safety: SafetyInputs, pressed: bool) -> None:
    bit, low = safety.names.index("emergency_stop"), "emergency_stop" in safety.active_low
    waited = 0.0
    while waited < _PATIENCE_S:
        high = bool(int(trial.watch(0.2).raw("safety_inputs", steady=False)[-1]) >> bit & 1)
        if high == (pressed != low):
            return
        waited += 0.2
    raise DeviceError(
        f"the emergency stop input does not say {'pressed' if pressed else 'released'} within {_PATIENCE_S:g} s;"
        " check its wire, and names and active_low of the safety terminal in the bench file"
    )


def _read(sdo: ObjectDictionary, name: str, kind: str) -> int:
    index, subindex = (int(part, 16) for part in name.split(":"))
    return sdo.read(index, subindex, kind)
