"""Why a bench stops: every cause, its sentence, and the rung of the stop ladder it begins at.

These limits protect equipment and data. Safety of people belongs in hardware: emergency stop, safe torque off, guards.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Rung(IntEnum):
    """The stop ladder: each step is harder than the one before."""

    NONE = 0
    CONTROLLED_RAMP = 1
    """Load taken off, then the input brought to rest at the bench's ramps."""
    QUICK_STOP = 2
    """The drives' own quick stop (0x605A)."""
    DISABLE_VOLTAGE = 3
    """No torque; the shafts coast."""
    STOP_SENDING = 4
    """No process data any more: the drives' own watchdogs act."""
    FINISHED = 5


class Cause(IntEnum):
    """What stopped the bench. The numbers are those of the compiled check."""

    NONE = 0
    MOTOR_SPEED = 1
    MOTOR_TORQUE = 2
    LOAD_TORQUE = 3
    LOAD_MOTOR_TORQUE = 4
    TEMPERATURE_HIGH = 5
    TEMPERATURE_LOW = 6
    TEMPERATURE_RATE = 7
    LOAD_POSITION = 8
    VELOCITY_ERROR = 9
    TORQUE_DISAGREEMENT = 10
    ENCODER_DISAGREEMENT = 11
    MOTOR_ENCODER_FROZEN = 12
    LOAD_ENCODER_FROZEN = 13
    TORQUE_SENSOR_FROZEN = 14
    TEMPERATURE_AGE = 15
    LOST_CYCLES = 16
    INPUT_DRIVE_FAULT = 17
    LOAD_DRIVE_FAULT = 18
    TORQUE_SENSOR_RANGE = 19
    TEMPERATURE_SENSOR = 20
    EMERGENCY_STOP = 21
    SAFE_TORQUE_OFF = 22
    LOAD_SPEED = 23
    MOTOR_ACCELERATION = 24
    LOAD_TORQUE_RATE = 25
    FOLLOWING_ERROR = 26
    TORQUE_ERROR = 27
    TORQUE_DRIFT = 28
    FRICTION = 29
    MOTOR_VELOCITY_FROZEN = 30
    LOAD_VELOCITY_FROZEN = 31
    MOTOR_TORQUE_FROZEN = 32
    LOAD_MOTOR_TORQUE_FROZEN = 33
    TEMPERATURE_FROZEN = 34
    LOST_SHARE = 35
    RECORDER = 99
    OPERATOR = 100
    BUS_ENDED = 101
    BUS_STOPPED = 102
    PROGRAM = 103
    """A sequence or the program that leads the run failed."""


@dataclass(frozen=True, slots=True)
class _Entry:
    text: str
    unit: str
    limit: str
    first_rung: Rung


_RAMP, _QUICK, _OFF = Rung.CONTROLLED_RAMP, Rung.QUICK_STOP, Rung.DISABLE_VOLTAGE

_TABLE: dict[Cause, _Entry] = {
    Cause.MOTOR_SPEED: _Entry("input motor speed", "rad/s", "limits.motor_speed", _OFF),
    Cause.MOTOR_TORQUE: _Entry("input motor torque", "N·m", "limits.motor_torque", _OFF),
    Cause.LOAD_TORQUE: _Entry("load torque", "N·m", "limits.load_torque", _OFF),
    Cause.LOAD_MOTOR_TORQUE: _Entry("load motor torque", "N·m", "limits.load_motor_torque", _OFF),
    Cause.TEMPERATURE_HIGH: _Entry("lubricant temperature", "°C", "limits.temperature", _RAMP),
    Cause.TEMPERATURE_LOW: _Entry("lubricant temperature", "°C", "limits.temperature_minimum", _RAMP),
    Cause.TEMPERATURE_RATE: _Entry("change of the temperature reading", "K", "limits.temperature_rate", _RAMP),
    Cause.LOAD_POSITION: _Entry("load-side angle", "rad", "limits.load_position", _RAMP),
    Cause.VELOCITY_ERROR: _Entry("velocity following error", "rad/s", "limits.velocity_error", _OFF),
    Cause.TORQUE_DISAGREEMENT: _Entry(
        "difference of torque sensor and load motor", "N·m", "limits.torque_disagreement", _RAMP
    ),
    Cause.ENCODER_DISAGREEMENT: _Entry("difference of the two encoders", "rad", "limits.encoder_disagreement", _OFF),
    Cause.MOTOR_ENCODER_FROZEN: _Entry("time the motor encoder stood still", "s", "limits.frozen_signal", _OFF),
    Cause.LOAD_ENCODER_FROZEN: _Entry("time the load encoder stood still", "s", "limits.frozen_signal", _RAMP),
    Cause.TORQUE_SENSOR_FROZEN: _Entry("time the torque sensor stood still", "s", "limits.frozen_signal", _RAMP),
    Cause.TEMPERATURE_AGE: _Entry("age of the temperature reading", "s", "limits.slow_reading_age", _RAMP),
    Cause.LOST_CYCLES: _Entry("number of lost cycles in a row", "", "limits.lost_cycles", _QUICK),
    Cause.LOST_SHARE: _Entry("share of lost cycles within a second", "", "limits.lost_share", _QUICK),
    Cause.INPUT_DRIVE_FAULT: _Entry("status word of the input drive", "", "operation enabled, no fault", _OFF),
    Cause.LOAD_DRIVE_FAULT: _Entry("status word of the load drive", "", "operation enabled, no fault", _QUICK),
    Cause.TORQUE_SENSOR_RANGE: _Entry("torque sensor reading", "N·m", "the range of its terminal", _RAMP),
    Cause.TEMPERATURE_SENSOR: _Entry(
        "temperature reading", "°C", "what the sensor can mean (open or short circuit)", _RAMP
    ),
    Cause.EMERGENCY_STOP: _Entry("emergency stop circuit", "", "closed", _QUICK),
    Cause.SAFE_TORQUE_OFF: _Entry("safe torque off circuit", "", "closed", _OFF),
    Cause.LOAD_SPEED: _Entry("load-side speed", "rad/s", "limits.load_speed", _OFF),
    Cause.MOTOR_ACCELERATION: _Entry("input motor acceleration", "rad/s²", "limits.motor_acceleration", _OFF),
    Cause.LOAD_TORQUE_RATE: _Entry("change of the load torque", "N·m/s", "limits.load_torque_rate", _OFF),
    Cause.FOLLOWING_ERROR: _Entry("following error of the motor angle", "rad", "limits.following_error", _OFF),
    Cause.TORQUE_ERROR: _Entry("difference of load motor torque and set value", "N·m", "limits.torque_error", _OFF),
    Cause.TORQUE_DRIFT: _Entry(
        "drift of the torque sensor against the load motor", "N·m", "limits.torque_drift", _RAMP
    ),
    Cause.FRICTION: _Entry(
        "motor torque beyond what the torque sensor accounts for", "N·m", "limits.friction_torque", _RAMP
    ),
    Cause.MOTOR_VELOCITY_FROZEN: _Entry("time the motor velocity stood still", "s", "limits.frozen_signal", _OFF),
    Cause.LOAD_VELOCITY_FROZEN: _Entry("time the load velocity stood still", "s", "limits.frozen_signal", _RAMP),
    Cause.MOTOR_TORQUE_FROZEN: _Entry("time the motor torque stood still", "s", "limits.frozen_signal", _RAMP),
    Cause.LOAD_MOTOR_TORQUE_FROZEN: _Entry(
        "time the load motor torque stood still", "s", "limits.frozen_signal", _RAMP
    ),
    Cause.TEMPERATURE_FROZEN: _Entry(
        "time the temperature read exactly the same", "s", "limits.frozen_temperature", _RAMP
    ),
    Cause.RECORDER: _Entry("recorder", "", "", _RAMP),
    Cause.OPERATOR: _Entry("operator's request", "", "", _RAMP),
    Cause.BUS_ENDED: _Entry("end of the bus process", "", "", Rung.STOP_SENDING),
    Cause.BUS_STOPPED: _Entry("stop by the bus process itself", "", "", _OFF),
    Cause.PROGRAM: _Entry("failure of the run's program", "", "", _RAMP),
}


def first_rung(cause: Cause) -> Rung:
    """Return where on the ladder a stop for this cause begins.

    Ramps and the drives' quick stop need a drive and an encoder that can be trusted: a velocity loop that believes a
    wrong encoder does not brake, it runs away. Where a drive does not follow its set value, or an encoder is in doubt,
    voltage goes off at once and friction brakes.
    """
    return _TABLE[cause].first_rung


_DEVICE_FAULTS = frozenset(
    {
        Cause.MOTOR_ENCODER_FROZEN,
        Cause.LOAD_ENCODER_FROZEN,
        Cause.TORQUE_SENSOR_FROZEN,
        Cause.TEMPERATURE_AGE,
        Cause.LOST_CYCLES,
        Cause.LOST_SHARE,
        Cause.INPUT_DRIVE_FAULT,
        Cause.LOAD_DRIVE_FAULT,
        Cause.TORQUE_SENSOR_RANGE,
        Cause.TEMPERATURE_SENSOR,
        Cause.BUS_ENDED,
        Cause.BUS_STOPPED,
        Cause.TORQUE_ERROR,
        Cause.TORQUE_DRIFT,
        Cause.MOTOR_VELOCITY_FROZEN,
        Cause.LOAD_VELOCITY_FROZEN,
        Cause.MOTOR_TORQUE_FROZEN,
        Cause.LOAD_MOTOR_TORQUE_FROZEN,
        Cause.TEMPERATURE_FROZEN,
    }
)


def is_device_fault(cause: Cause) -> bool:
    """Whether a device or the bus failed, rather than the motion having gone beyond a limit."""
    return cause in _DEVICE_FAULTS


def describe(cause: Cause, value: float, limit: float) -> str:
    """Return the sentence an operator reads, values in SI."""
    entry = _TABLE[cause]
    if cause is Cause.OPERATOR:
        return "stopped on the operator's request"
    if entry.limit.startswith("limits."):
        unit = f" {entry.unit}" if entry.unit else ""
        seen, allowed = _distinguishable(value, limit)
        if value == limit:
            return f"{entry.text} {seen}{unit} has reached {entry.limit} = {allowed}{unit}"
        below = cause is Cause.TEMPERATURE_LOW
        by = limit - value if below else abs(value) - limit
        return f"{entry.text} {seen}{unit} is beyond {entry.limit} = {allowed}{unit} by {_short(by)}{unit}"
    if cause is Cause.TEMPERATURE_SENSOR:
        return "the thermometer gives no valid reading: open or short circuit, or its line is silent"
    if cause in (Cause.EMERGENCY_STOP, Cause.SAFE_TORQUE_OFF):
        return f"the {entry.text} is open: it was demanded, or its wire is broken"
    if cause in (Cause.INPUT_DRIVE_FAULT, Cause.LOAD_DRIVE_FAULT):
        return f"{entry.text} is 0x{round(value):04X}, expected: {entry.limit}"
    return f"{entry.text} {value:.4g} {entry.unit}".rstrip() + f" is outside {entry.limit}"


_DIGITS = range(4, 18)


def _distinguishable(value: float, limit: float) -> tuple[str, str]:
    """Return both with as few digits as distinguish them, four at least."""
    for digits in _DIGITS:
        seen, allowed = f"{value:.{digits}g}", f"{limit:.{digits}g}"
        if value == limit or abs(float(seen)) != abs(float(allowed)):
            break
    return seen, allowed


def _short(value: float) -> str:
    """Return a number with two digits, or its whole part."""
    return f"{value:.0f}" if abs(value) >= 10.0 else f"{value:.2g}"
