"""The common zero of the two encoders: approached unloaded, always from the same side, twice.

One revolution of the motor is 2π / ratio at the output (34 mrad for a ratio of 185), and a single-turn encoder on the
motor does not count revolutions. The load encoder says which revolution it is. The angle within it is found by passing
the load side's zero slowly and without load, so that windup and backlash are always the same. A number
is left in both drives that a power cut takes away: then the zero has to be found again.
"""

from __future__ import annotations

import math
import secrets
from datetime import UTC, datetime

import numpy as np

from bench.commissioning.record import Zero
from bench.commissioning.slaves import DRIVES
from bench.commissioning.trial import Trial
from bench.cycle.assembly import device_errors
from bench.cycle.rig import Rig
from bench.errors import DeviceError, LimitError
from bench.protocols import Phase, Segment

_BEFORE = 3.0
"""Turns of the motor before the zero, in which the motion settles."""


def find_zero(trial: Trial) -> tuple[str, Zero]:
    """Approach the load side's zero twice and take the encoders' mean difference over a revolution of the motor.

    Raises
    ------
    DeviceError
        If the two approaches differ by more than commissioning.zero_spread.
    """
    found = [_approach(trial) for _ in range(2)]
    spread = abs(found[1] - found[0])
    allowed = trial.bench.commissioning.zero_spread
    if spread > allowed:
        raise DeviceError(
            f"two approaches to the encoders' zero differ by {1e6 * spread:.0f} µrad at the load side, more than"
            f" commissioning.zero_spread = {1e6 * allowed:.0f} µrad; is the output free, and the coupling tight?"
        )
    now = datetime.now(UTC)
    ratio = trial.bench.gearbox.ratio
    # motor' = motor − z, so that load − motor'/ratio is nought on the mean: z = −ratio · difference
    angle = trial.rig.zeros.motor_angle - trial.bench.input_encoder.zero - ratio * float(np.mean(found))
    zero = Zero(
        f"{now:%Y-%m-%dT%H%M%S}-{secrets.token_hex(2)}",
        math.remainder(angle, 2.0 * math.pi),
        spread,
        secrets.randbelow(0x7FFFFFFE) + 1,
        now.isoformat(timespec="seconds"),
        trial.by,
    )
    mark(trial.rig, zero.marker, trial.bench.commissioning.marker)
    trial.values.update(zero_id=zero.zero_id, motor_angle_rad=zero.motor_angle, spread_rad=spread)
    return f"zero {zero.zero_id}: two approaches agree within {1e6 * spread:.1f} µrad", zero


def mark(rig: Rig, marker: int, where: str) -> None:
    """Leave a number in both drives that they forget at power-off."""
    index, subindex = (int(part, 16) for part in where.split(":"))
    with device_errors():
        for role in DRIVES:
            rig.link.assembly.bus.sdo(role).write(index, subindex, "u4", marker)


def require_zero(rig: Rig, zero: Zero) -> None:
    """Refuse a bench whose drives have lost their power since its zero was found.

    Raises
    ------
    LimitError
        Naming the drive.
    """
    index, subindex = (int(part, 16) for part in rig.bench.commissioning.marker.split(":"))
    with device_errors():
        for role in DRIVES:
            if rig.link.assembly.bus.sdo(role).read(index, subindex, "u4") != zero.marker:
                raise LimitError(
                    f"the {role.replace('_', ' ')} has lost its power since zero {zero.zero_id} was found; run bench"
                    f" commission --zero --bus {rig.bench.bus.interface}"
                )


def _approach(trial: Trial) -> float:
    """Return the mean of load_angle − motor_angle / ratio over a motor revolution around the load side's zero."""
    motor_revolution = 2.0 * math.pi / trial.bench.gearbox.ratio
    start = -_BEFORE * motor_revolution
    position = _position(trial)
    # to the start from below: the last motion before the zero is always upwards
    trial.move(_travel(trial, start - motor_revolution - position))
    trial.move(_travel(trial, motor_revolution))
    tape = trial.move(_travel(trial, 2.0 * _BEFORE * motor_revolution))
    load, motor = trial.si(tape, "load_angle", steady=False), trial.si(tape, "motor_angle", steady=False)
    near = np.abs(load) < 0.5 * motor_revolution
    if not near.any():
        raise DeviceError("the load side's zero was not passed; is its encoder's zero in the bench file reachable?")
    return float(np.mean((load - motor / trial.bench.gearbox.ratio)[near]))


def _position(trial: Trial) -> float:
    tape = trial.watch(0.1)
    return float(np.mean(trial.si(tape, "load_angle", steady=False)))


def _travel(trial: Trial, distance: float) -> tuple[Phase, ...]:
    """Return phases that move the load side by a distance at the trial's speed, slower where it is short."""
    if abs(distance) < 1e-9:
        return ()
    motion, ratio = trial.bench.motion, trial.bench.gearbox.ratio
    acceleration = motion.motor_acceleration / ratio
    speed = math.copysign(min(trial.speed, math.sqrt(abs(distance) * acceleration)), distance)
    ramp = abs(speed) / acceleration
    return (
        Phase(None, ramp, speed, 0.0),
        Phase(Segment.STEADY, max(0.0, abs(distance / speed) - ramp), speed, 0.0),
        Phase(None, ramp, 0.0, 0.0),
        Phase(None, 0.3, 0.0, 0.0),
    )
