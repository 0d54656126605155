"""What the safety step makes of the signals of a cycle: filters, differences, rates, ages, in slots of the memory.

Fast signals are judged after a first-order low pass, because one count of a coarse encoder looks like a jump in speed;
the time constants are far below any ramp of the bench.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.safety._slots import FROZEN, LIVE, Slot

FloatArray = NDArray[np.float64]

SPEED_FILTER_S = 0.02
TORQUE_FILTER_S = 0.01
RATE_FILTER_S = 0.05
DISAGREEMENT_FILTER_S = 0.1
FOLLOWING_S = 1.0
"""Over this time the angle lost against the set velocity is summed up: a leaky integral forgets missed slots."""
TEMPERATURE_S = 1.0
LOST_S = 1.0
DRIFT_S = 60.0

LOW_PASSES: tuple[tuple[Slot, float], ...] = (
    (Slot.SPEED, SPEED_FILTER_S),
    (Slot.SETPOINT, SPEED_FILTER_S),
    (Slot.LOAD_SPEED, SPEED_FILTER_S),
    (Slot.MOTOR_TORQUE, TORQUE_FILTER_S),
    (Slot.LOAD_TORQUE, TORQUE_FILTER_S),
    (Slot.LOAD_MOTOR_TORQUE, TORQUE_FILTER_S),
    (Slot.DISAGREEMENT, DISAGREEMENT_FILTER_S),
    (Slot.DRIFT, DRIFT_S),
    (Slot.FRICTION, DISAGREEMENT_FILTER_S),
)
"""Slots one after the other, and their time constants, s."""
_DISAGREEING, _RATE, _TEMPERATURE_LAG, _LOST = range(len(LOW_PASSES), len(LOW_PASSES) + 4)
"""Places of the other gains, behind those of the low passes."""
_OPERATION_ENABLED, _OPERATION_MASK = 0x0027, 0x006F
"""CiA 402 status word 0x6041: operation enabled is xxxx xxxx x01x 0111."""


class Signal(IntEnum):
    """Rows of the signals of a block: the fields of :class:`bench.safety.judge.Inputs` in their order."""

    MOTOR_COUNTS = 0
    LOAD_COUNTS = 1
    TORQUE_COUNTS = 2
    MOTOR_ANGLE = 3
    LOAD_ANGLE = 4
    MOTOR_VELOCITY = 5
    LOAD_VELOCITY = 6
    MOTOR_TORQUE = 7
    LOAD_TORQUE = 8
    LOAD_MOTOR_TORQUE = 9
    TEMPERATURE = 10
    TEMPERATURE_AGE = 11
    VELOCITY_SETPOINT = 12
    TORQUE_SETPOINT = 13
    INPUT_STATUS = 14
    LOAD_STATUS = 15
    TORQUE_BAD = 16
    EMERGENCY_STOP = 17
    SAFE_TORQUE_OFF = 18
    GOOD = 19


_COPIED = np.array(
    [
        (Slot.EMERGENCY_STOP, Signal.EMERGENCY_STOP),
        (Slot.SAFE_TORQUE_OFF, Signal.SAFE_TORQUE_OFF),
        (Slot.INPUT_STATUS, Signal.INPUT_STATUS),
        (Slot.LOAD_STATUS, Signal.LOAD_STATUS),
        (Slot.TORQUE_BAD, Signal.TORQUE_BAD),
        (Slot.TORQUE_READING, Signal.LOAD_TORQUE),
        (Slot.TEMPERATURE, Signal.TEMPERATURE),
        (Slot.TEMPERATURE_AGE, Signal.TEMPERATURE_AGE),
        (Slot.LOAD_ANGLE, Signal.LOAD_ANGLE),
    ]
)
_LIVE_SIGNALS = np.array(
    [
        Signal.MOTOR_COUNTS,
        Signal.LOAD_COUNTS,
        Signal.TORQUE_COUNTS,
        Signal.MOTOR_VELOCITY,
        Signal.LOAD_VELOCITY,
        Signal.MOTOR_TORQUE,
        Signal.LOAD_MOTOR_TORQUE,
        Signal.TEMPERATURE,
    ]
)
_FIRST_LOW_PASS, _LAST, _TEMPERATURE_IS = int(Slot.SPEED), int(Slot.LAST), len(LIVE) - 1


def gains(cycle_time_s: float) -> FloatArray:
    """Return the shares by which the low passes, and whatever else follows, follow in a cycle."""
    constants = [*(constant for _, constant in LOW_PASSES), DISAGREEMENT_FILTER_S, RATE_FILTER_S, TEMPERATURE_S, LOST_S]
    return np.array([cycle_time_s / (cycle_time_s + constant) for constant in constants])


@njit(cache=True)
def count_losses(memory: FloatArray, lost: bool, follow: FloatArray) -> None:
    """Count a cycle that was lost, or one that was not."""
    memory[Slot.LOST_IN_A_ROW] = memory[Slot.LOST_IN_A_ROW] + 1.0 if lost else 0.0
    memory[Slot.LOST_SHARE] += follow[_LOST] * ((1.0 if lost else 0.0) - memory[Slot.LOST_SHARE])


@njit(cache=True)
def _is_out(word: float) -> float:
    """1 where a status word says anything but operation enabled."""
    return 1.0 if int(word) & _OPERATION_MASK != _OPERATION_ENABLED else 0.0


@njit(cache=True)
def observe(
    memory: FloatArray,
    signals: FloatArray,
    i: int,
    operating: bool,
    ratio: float,
    cycle_time: float,
    standstill: float,
    follow: FloatArray,
) -> None:
    """Take good cycle ``i`` of the signals (20, n) into the memory; ``follow`` are the gains."""
    m, s = memory, signals
    for k in range(_COPIED.shape[0]):
        m[_COPIED[k, 0]] = s[_COPIED[k, 1], i]
    m[Slot.INPUT_IS_OUT] = _is_out(s[Signal.INPUT_STATUS, i])
    m[Slot.LOAD_IS_OUT] = _is_out(s[Signal.LOAD_STATUS, i])
    m[Slot.TEMPERATURE_INVALID] = 1.0 if np.isnan(s[Signal.TEMPERATURE, i]) else 0.0
    load_torque, load_motor_torque = s[Signal.LOAD_TORQUE, i], s[Signal.LOAD_MOTOR_TORQUE, i]
    difference = s[Signal.LOAD_ANGLE, i] - s[Signal.MOTOR_ANGLE, i] / ratio
    disagreement = load_torque - load_motor_torque
    sources = (
        s[Signal.MOTOR_VELOCITY, i],
        s[Signal.VELOCITY_SETPOINT, i],
        s[Signal.LOAD_VELOCITY, i],
        s[Signal.MOTOR_TORQUE, i],
        load_torque,
        load_motor_torque,
        disagreement,
        disagreement,
        s[Signal.MOTOR_TORQUE, i] - load_torque / ratio,
    )
    first = m[Slot.STARTED] == 0.0
    if first:
        m[Slot.STARTED] = 1.0
        m[Slot.ENCODER_REFERENCE] = difference
        m[Slot.TEMPERATURE_REFERENCE] = s[Signal.TEMPERATURE, i]
        for k in range(len(sources)):
            m[_FIRST_LOW_PASS + k] = sources[k]
    before_speed, before_torque = m[Slot.SPEED], m[Slot.LOAD_TORQUE]
    for k in range(len(sources)):
        m[_FIRST_LOW_PASS + k] += follow[k] * (sources[k] - m[_FIRST_LOW_PASS + k])

    slow, rate, per_s = follow[_DISAGREEING], follow[_RATE], 1.0 / cycle_time
    if operating:
        m[Slot.TORQUE_ERROR] += slow * (load_motor_torque - s[Signal.TORQUE_SETPOINT, i] - m[Slot.TORQUE_ERROR])
    m[Slot.ACCELERATION] += rate * ((m[Slot.SPEED] - before_speed) * per_s - m[Slot.ACCELERATION])
    m[Slot.TORQUE_RATE] += rate * ((m[Slot.LOAD_TORQUE] - before_torque) * per_s - m[Slot.TORQUE_RATE])
    m[Slot.VELOCITY_ERROR] = m[Slot.SPEED] - m[Slot.SETPOINT]
    lost_angle = -m[Slot.VELOCITY_ERROR] * cycle_time if operating else 0.0
    m[Slot.FOLLOWING] += lost_angle - m[Slot.FOLLOWING] * (cycle_time / FOLLOWING_S)
    m[Slot.ENCODER_DIFFERENCE] = difference - m[Slot.ENCODER_REFERENCE]

    # the reference follows with a time constant of one second: a step larger than the limit is not heat
    m[Slot.TEMPERATURE_JUMP] = s[Signal.TEMPERATURE, i] - m[Slot.TEMPERATURE_REFERENCE]
    m[Slot.TEMPERATURE_REFERENCE] += follow[_TEMPERATURE_LAG] * m[Slot.TEMPERATURE_JUMP]

    # the slow mean of the first minute is what later ones are compared with
    m[Slot.DRIFT_AGE] += cycle_time
    if m[Slot.DRIFT_AGE] <= DRIFT_S:
        m[Slot.DRIFT_REFERENCE] = m[Slot.DRIFT]
    m[Slot.TORQUE_DRIFT] = m[Slot.DRIFT] - m[Slot.DRIFT_REFERENCE]

    # an encoder must move when a motion of its shaft is set; a live analogue signal is never exactly constant for long
    moving = operating and abs(m[Slot.SETPOINT]) > 4.0 * standstill
    for k in range(_LIVE_SIGNALS.size):
        value = s[_LIVE_SIGNALS[k], i]
        lives = value != m[_LAST + k] or not (moving or k == _TEMPERATURE_IS)
        m[FROZEN + k] = 0.0 if lives else m[FROZEN + k] + cycle_time
        m[_LAST + k] = value
