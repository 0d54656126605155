"""The compiled loop of the safety step: one pass over the cycles, stops at the first that breaks a limit.

Causes are the numbers of :class:`bench.safety.causes.Cause`, and ``limits`` is indexed by them. Fast signals are judged
after a first-order low pass, because one count of a coarse encoder looks like a jump in speed; its time constants are
far below any ramp of the bench.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.safety.causes import Cause

SPEED_FILTER_S = 0.02
TORQUE_FILTER_S = 0.01
RATE_FILTER_S = 0.05
DISAGREEMENT_FILTER_S = 0.1
FOLLOWING_S = 1.0
"""Over this time the angle lost against the set velocity is summed up: a leaky integral forgets missed slots."""
DRIFT_S = 60.0

# slots of the memory
_STARTED, _SPEED, _SETPOINT, _MOTOR_TORQUE, _LOAD_TORQUE, _LOAD_MOTOR_TORQUE, _DISAGREEMENT = range(7)
_REFERENCE, _TEMPERATURE, _LOST, _LOAD_SPEED, _ACCELERATION, _TORQUE_RATE, _FOLLOWING, _TORQUE_ERROR = range(7, 15)
_DRIFT, _DRIFT_REFERENCE, _DRIFT_AGE, _FRICTION = range(15, 19)
_LAST, _FROZEN = 20, 28
"""First of the last values, and of the cycles for which they have not changed, of the signals that must live."""
STATE_SIZE = 36

_OPERATION_ENABLED = 0x0027
_OPERATION_MASK = 0x006F
"""CiA 402 status word 0x6041: operation enabled is xxxx xxxx x01x 0111."""

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
"""Signals that must live, in the order of the last values; the temperature has to also while nothing moves."""
_LIVE_CODES = np.array([int(cause) for cause in LIVE])
_ALWAYS = len(LIVE) - 1

_EMERGENCY, _STO = int(Cause.EMERGENCY_STOP), int(Cause.SAFE_TORQUE_OFF)
_LOAD_SPEED_CODE, _ACCELERATION_CODE = int(Cause.LOAD_SPEED), int(Cause.MOTOR_ACCELERATION)
_RATE_CODE, _FOLLOWING_CODE = int(Cause.LOAD_TORQUE_RATE), int(Cause.FOLLOWING_ERROR)
_ERROR_CODE, _DRIFT_CODE, _FRICTION_CODE = int(Cause.TORQUE_ERROR), int(Cause.TORQUE_DRIFT), int(Cause.FRICTION)


@njit(cache=True)
def scan(
    memory: NDArray[np.float64],
    motor_counts: NDArray[np.integer[Any]],
    load_counts: NDArray[np.integer[Any]],
    torque_counts: NDArray[np.integer[Any]],
    motor_angle: NDArray[np.float64],
    load_angle: NDArray[np.float64],
    motor_velocity: NDArray[np.float64],
    load_velocity: NDArray[np.float64],
    motor_torque: NDArray[np.float64],
    load_torque: NDArray[np.float64],
    load_motor_torque: NDArray[np.float64],
    temperature: NDArray[np.float64],
    temperature_age: NDArray[np.float64],
    velocity_setpoint: NDArray[np.float64],
    torque_setpoint: NDArray[np.float64],
    input_status: NDArray[np.integer[Any]],
    load_status: NDArray[np.integer[Any]],
    torque_bad: NDArray[np.bool_],
    emergency_stop: NDArray[np.bool_],
    safe_torque_off: NDArray[np.bool_],
    good: NDArray[np.bool_],
    operating: bool,
    ratio: float,
    cycle_time: float,
    standstill: float,
    limits: NDArray[np.float64],
) -> tuple[int, int, float]:
    """Return (cycle, cause, value) of the first bad cycle, or (−1, 0, 0.0); updates ``memory`` in place."""
    fast = cycle_time / (cycle_time + TORQUE_FILTER_S)
    medium = cycle_time / (cycle_time + SPEED_FILTER_S)
    rate = cycle_time / (cycle_time + RATE_FILTER_S)
    slow = cycle_time / (cycle_time + DISAGREEMENT_FILTER_S)
    crawl = cycle_time / (cycle_time + DRIFT_S)
    for i in range(good.size):
        if not good[i]:
            memory[_LOST] += 1.0
            if memory[_LOST] >= limits[16]:
                return i, 16, memory[_LOST]
            continue
        memory[_LOST] = 0.0
        # people first: what the safety circuit says is looked at before any measurement
        if emergency_stop[i]:
            return i, _EMERGENCY, 1.0
        if safe_torque_off[i]:
            return i, _STO, 1.0
        difference = load_angle[i] - motor_angle[i] / ratio
        disagreement = load_torque[i] - load_motor_torque[i]
        friction = motor_torque[i] - load_torque[i] / ratio
        torque_error = load_motor_torque[i] - torque_setpoint[i]
        if memory[_STARTED] == 0.0:
            memory[_STARTED] = 1.0
            memory[_SPEED] = motor_velocity[i]
            memory[_SETPOINT] = velocity_setpoint[i]
            memory[_LOAD_SPEED] = load_velocity[i]
            memory[_MOTOR_TORQUE] = motor_torque[i]
            memory[_LOAD_TORQUE] = load_torque[i]
            memory[_LOAD_MOTOR_TORQUE] = load_motor_torque[i]
            memory[_DISAGREEMENT] = disagreement
            memory[_DRIFT] = disagreement
            memory[_FRICTION] = friction
            memory[_REFERENCE] = difference
            memory[_TEMPERATURE] = temperature[i]
        before_speed, before_torque = memory[_SPEED], memory[_LOAD_TORQUE]
        memory[_SPEED] += medium * (motor_velocity[i] - memory[_SPEED])
        memory[_SETPOINT] += medium * (velocity_setpoint[i] - memory[_SETPOINT])
        memory[_LOAD_SPEED] += medium * (load_velocity[i] - memory[_LOAD_SPEED])
        memory[_MOTOR_TORQUE] += fast * (motor_torque[i] - memory[_MOTOR_TORQUE])
        memory[_LOAD_TORQUE] += fast * (load_torque[i] - memory[_LOAD_TORQUE])
        memory[_LOAD_MOTOR_TORQUE] += fast * (load_motor_torque[i] - memory[_LOAD_MOTOR_TORQUE])
        memory[_DISAGREEMENT] += slow * (disagreement - memory[_DISAGREEMENT])
        memory[_DRIFT] += crawl * (disagreement - memory[_DRIFT])
        memory[_FRICTION] += slow * (friction - memory[_FRICTION])
        memory[_TORQUE_ERROR] += slow * (torque_error - memory[_TORQUE_ERROR]) if operating else 0.0
        memory[_ACCELERATION] += rate * ((memory[_SPEED] - before_speed) / cycle_time - memory[_ACCELERATION])
        memory[_TORQUE_RATE] += rate * ((memory[_LOAD_TORQUE] - before_torque) / cycle_time - memory[_TORQUE_RATE])
        lost = (memory[_SETPOINT] - memory[_SPEED]) * cycle_time if operating else 0.0
        memory[_FOLLOWING] += lost - memory[_FOLLOWING] * cycle_time / FOLLOWING_S
        if operating:
            if input_status[i] & _OPERATION_MASK != _OPERATION_ENABLED:
                return i, 17, float(input_status[i])
            if load_status[i] & _OPERATION_MASK != _OPERATION_ENABLED:
                return i, 18, float(load_status[i])
        if torque_bad[i]:
            return i, 19, load_torque[i]
        if math.isnan(temperature[i]):
            return i, 20, temperature[i]
        if abs(memory[_SPEED]) > limits[1]:
            return i, 1, memory[_SPEED]
        if abs(memory[_LOAD_SPEED]) > limits[_LOAD_SPEED_CODE]:
            return i, _LOAD_SPEED_CODE, memory[_LOAD_SPEED]
        if abs(memory[_MOTOR_TORQUE]) > limits[2]:
            return i, 2, memory[_MOTOR_TORQUE]
        if abs(memory[_LOAD_TORQUE]) > limits[3]:
            return i, 3, memory[_LOAD_TORQUE]
        if abs(memory[_LOAD_MOTOR_TORQUE]) > limits[4]:
            return i, 4, memory[_LOAD_MOTOR_TORQUE]
        if temperature[i] > limits[5]:
            return i, 5, temperature[i]
        if temperature[i] < limits[6]:
            return i, 6, temperature[i]
        # the reference follows with a time constant of one second: a step larger than the limit is not heat
        if abs(temperature[i] - memory[_TEMPERATURE]) > limits[7]:
            return i, 7, temperature[i] - memory[_TEMPERATURE]
        memory[_TEMPERATURE] += cycle_time / (cycle_time + 1.0) * (temperature[i] - memory[_TEMPERATURE])
        if abs(load_angle[i]) > limits[8]:
            return i, 8, load_angle[i]
        if operating:
            if abs(memory[_SPEED] - memory[_SETPOINT]) > limits[9]:
                return i, 9, memory[_SPEED] - memory[_SETPOINT]
            if abs(memory[_FOLLOWING]) > limits[_FOLLOWING_CODE]:
                return i, _FOLLOWING_CODE, memory[_FOLLOWING]
            if abs(memory[_ACCELERATION]) > limits[_ACCELERATION_CODE]:
                return i, _ACCELERATION_CODE, memory[_ACCELERATION]
            if abs(memory[_TORQUE_ERROR]) > limits[_ERROR_CODE]:
                return i, _ERROR_CODE, memory[_TORQUE_ERROR]
        if abs(memory[_TORQUE_RATE]) > limits[_RATE_CODE]:
            return i, _RATE_CODE, memory[_TORQUE_RATE]
        if abs(memory[_DISAGREEMENT]) > limits[10]:
            return i, 10, memory[_DISAGREEMENT]
        if abs(difference - memory[_REFERENCE]) > limits[11]:
            return i, 11, difference - memory[_REFERENCE]
        if abs(memory[_FRICTION]) > limits[_FRICTION_CODE]:
            return i, _FRICTION_CODE, memory[_FRICTION]
        # the slow mean of the first minute is what later ones are compared with
        memory[_DRIFT_AGE] += cycle_time
        if memory[_DRIFT_AGE] <= DRIFT_S:
            memory[_DRIFT_REFERENCE] = memory[_DRIFT]
        elif abs(memory[_DRIFT] - memory[_DRIFT_REFERENCE]) > limits[_DRIFT_CODE]:
            return i, _DRIFT_CODE, memory[_DRIFT] - memory[_DRIFT_REFERENCE]
        # an encoder must move when its shaft is told to; a live analogue signal is never exactly constant for long
        moving = operating and abs(memory[_SETPOINT]) > 4.0 * standstill
        for k in range(_LIVE_CODES.size):
            if k == 0:
                value = float(motor_counts[i])
            elif k == 1:
                value = float(load_counts[i])
            elif k == 2:
                value = float(torque_counts[i])
            elif k == 3:
                value = motor_velocity[i]
            elif k == 4:
                value = load_velocity[i]
            elif k == 5:
                value = motor_torque[i]
            elif k == 6:
                value = load_motor_torque[i]
            else:
                value = temperature[i]
            lives = value != memory[_LAST + k] or not (moving or k == _ALWAYS)
            memory[_FROZEN + k] = 0.0 if lives else memory[_FROZEN + k] + 1.0
            memory[_LAST + k] = value
            if memory[_FROZEN + k] * cycle_time > limits[_LIVE_CODES[k]]:
                return i, int(_LIVE_CODES[k]), memory[_FROZEN + k] * cycle_time
        if temperature_age[i] > limits[15]:
            return i, 15, temperature_age[i]
    return -1, 0, 0.0
