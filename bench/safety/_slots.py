"""The memory of the safety step: one number a slot, carried from cycle to cycle. Rules look at slots by name."""

from __future__ import annotations

from enum import IntEnum

from bench.safety.causes import Cause

LIVE: tuple[Cause, ...] = (
    Cause.MOTOR_ENCODER_FROZEN,
    Cause.LOAD_ENCODER_FROZEN,
    Cause.TORQUE_SENSOR_FROZEN,
    Cause.MOTOR_VELOCITY_FROZEN,
    Cause.LOAD_VELOCITY_FROZEN,
    Cause.MOTOR_TORQUE_FROZEN,
    Cause.LOAD_MOTOR_TORQUE_FROZEN,
    Cause.TEMPERATURE_FROZEN,
)
"""Signals that must live, in the order of their slots; the temperature, the last, has to also while nothing moves."""


class Slot(IntEnum):
    """What is remembered, SI units."""

    STARTED = 0
    """0 before the first good cycle."""

    # of this cycle
    LOST_IN_A_ROW = 1
    EMERGENCY_STOP = 2
    SAFE_TORQUE_OFF = 3
    INPUT_STATUS = 4
    LOAD_STATUS = 5
    TORQUE_BAD = 6
    TORQUE_READING = 7
    TEMPERATURE = 8
    TEMPERATURE_AGE = 9
    LOAD_ANGLE = 10
    ENCODER_DIFFERENCE = 11
    """Of load angle and motor angle over ratio, against that at the start, rad."""
    TEMPERATURE_JUMP = 12
    """Against a reference that follows within a second, K."""

    # first-order low passes (their time constants: _observe.LOW_PASSES)
    SPEED = 13
    SETPOINT = 14
    LOAD_SPEED = 15
    MOTOR_TORQUE = 16
    LOAD_TORQUE = 17
    LOAD_MOTOR_TORQUE = 18
    DISAGREEMENT = 19
    DRIFT = 20
    FRICTION = 21

    # made of them
    LOST_SHARE = 22
    """Share of the cycles of about the last second that were lost."""
    TORQUE_ERROR = 23
    ACCELERATION = 24
    TORQUE_RATE = 25
    FOLLOWING = 26
    """Angle lost against the set velocity within about a second, rad."""
    VELOCITY_ERROR = 27
    TORQUE_DRIFT = 28
    """The disagreement's mean of a minute against its first, N·m; 0 in the first minute."""

    # how long each live signal has been exactly the same, s
    MOTOR_COUNTS_STILL = 29
    LOAD_COUNTS_STILL = 30
    TORQUE_COUNTS_STILL = 31
    MOTOR_VELOCITY_STILL = 32
    LOAD_VELOCITY_STILL = 33
    MOTOR_TORQUE_STILL = 34
    LOAD_MOTOR_TORQUE_STILL = 35
    TEMPERATURE_STILL = 36

    # references and flags
    ENCODER_REFERENCE = 37
    TEMPERATURE_REFERENCE = 38
    DRIFT_REFERENCE = 39
    DRIFT_AGE = 40
    INPUT_IS_OUT = 41
    LOAD_IS_OUT = 42
    TEMPERATURE_INVALID = 43
    LAST = 44
    """First of the last values of the live signals."""


FROZEN = int(Slot.MOTOR_COUNTS_STILL)
STATE_SIZE = int(Slot.LAST) + len(LIVE)
