"""The compiled loop of the safety step: one pass over the cycles, stops at the first that breaks a limit.

Causes are the numbers of :class:`bench.safety.causes.Cause`. Fast signals are judged after a first-order low pass,
because one count of a coarse encoder looks like a jump in speed; its time constants are far below any ramp of the
bench.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

SPEED_FILTER_S = 0.02
TORQUE_FILTER_S = 0.01
DISAGREEMENT_FILTER_S = 0.1

# slots of the memory
_STARTED, _SPEED, _SETPOINT, _MOTOR_TORQUE, _LOAD_TORQUE, _LOAD_MOTOR_TORQUE, _DISAGREEMENT = range(7)
_REFERENCE, _TEMPERATURE, _LOST = 7, 8, 9
_LAST_MOTOR, _LAST_LOAD, _LAST_TORQUE, _FROZEN_MOTOR, _FROZEN_LOAD, _FROZEN_TORQUE = range(10, 16)
STATE_SIZE = 16

_OPERATION_ENABLED = 0x0027
_OPERATION_MASK = 0x006F
"""CiA 402 status word 0x6041: operation enabled is xxxx xxxx x01x 0111."""


@njit(cache=True)
def scan(
    memory: NDArray[np.float64],
    motor_counts: NDArray[np.integer[Any]],
    load_counts: NDArray[np.integer[Any]],
    torque_counts: NDArray[np.integer[Any]],
    motor_angle: NDArray[np.float64],
    load_angle: NDArray[np.float64],
    motor_velocity: NDArray[np.float64],
    motor_torque: NDArray[np.float64],
    load_torque: NDArray[np.float64],
    load_motor_torque: NDArray[np.float64],
    temperature: NDArray[np.float64],
    temperature_age: NDArray[np.float64],
    velocity_setpoint: NDArray[np.float64],
    input_status: NDArray[np.integer[Any]],
    load_status: NDArray[np.integer[Any]],
    torque_bad: NDArray[np.bool_],
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
    slow = cycle_time / (cycle_time + DISAGREEMENT_FILTER_S)
    for i in range(good.size):
        if not good[i]:
            memory[_LOST] += 1.0
            if memory[_LOST] >= limits[16]:
                return i, 16, memory[_LOST]
            continue
        memory[_LOST] = 0.0
        difference = load_angle[i] - motor_angle[i] / ratio
        if memory[_STARTED] == 0.0:
            memory[_STARTED] = 1.0
            memory[_SPEED] = motor_velocity[i]
            memory[_SETPOINT] = velocity_setpoint[i]
            memory[_MOTOR_TORQUE] = motor_torque[i]
            memory[_LOAD_TORQUE] = load_torque[i]
            memory[_LOAD_MOTOR_TORQUE] = load_motor_torque[i]
            memory[_DISAGREEMENT] = load_torque[i] - load_motor_torque[i]
            memory[_REFERENCE] = difference
            memory[_TEMPERATURE] = temperature[i]
            memory[_LAST_MOTOR] = motor_counts[i]
            memory[_LAST_LOAD] = load_counts[i]
            memory[_LAST_TORQUE] = torque_counts[i]
        memory[_SPEED] += medium * (motor_velocity[i] - memory[_SPEED])
        memory[_SETPOINT] += medium * (velocity_setpoint[i] - memory[_SETPOINT])
        memory[_MOTOR_TORQUE] += fast * (motor_torque[i] - memory[_MOTOR_TORQUE])
        memory[_LOAD_TORQUE] += fast * (load_torque[i] - memory[_LOAD_TORQUE])
        memory[_LOAD_MOTOR_TORQUE] += fast * (load_motor_torque[i] - memory[_LOAD_MOTOR_TORQUE])
        memory[_DISAGREEMENT] += slow * (load_torque[i] - load_motor_torque[i] - memory[_DISAGREEMENT])
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
        if operating and abs(memory[_SPEED] - memory[_SETPOINT]) > limits[9]:
            return i, 9, memory[_SPEED] - memory[_SETPOINT]
        if abs(memory[_DISAGREEMENT]) > limits[10]:
            return i, 10, memory[_DISAGREEMENT]
        if abs(difference - memory[_REFERENCE]) > limits[11]:
            return i, 11, difference - memory[_REFERENCE]
        # an encoder must move when its shaft is told to; a live analogue signal is never exactly constant for long
        moving = operating and abs(memory[_SETPOINT]) > 4.0 * standstill
        memory[_FROZEN_MOTOR] = (
            0.0 if motor_counts[i] != memory[_LAST_MOTOR] or not moving else memory[_FROZEN_MOTOR] + 1
        )
        memory[_FROZEN_LOAD] = 0.0 if load_counts[i] != memory[_LAST_LOAD] or not moving else memory[_FROZEN_LOAD] + 1
        memory[_FROZEN_TORQUE] = (
            0.0 if torque_counts[i] != memory[_LAST_TORQUE] or not moving else memory[_FROZEN_TORQUE] + 1
        )
        memory[_LAST_MOTOR] = motor_counts[i]
        memory[_LAST_LOAD] = load_counts[i]
        memory[_LAST_TORQUE] = torque_counts[i]
        if memory[_FROZEN_MOTOR] * cycle_time > limits[12]:
            return i, 12, memory[_FROZEN_MOTOR] * cycle_time
        if memory[_FROZEN_LOAD] * cycle_time > limits[13]:
            return i, 13, memory[_FROZEN_LOAD] * cycle_time
        if memory[_FROZEN_TORQUE] * cycle_time > limits[14]:
            return i, 14, memory[_FROZEN_TORQUE] * cycle_time
        if temperature_age[i] > limits[15]:
            return i, 15, temperature_age[i]
    return -1, 0, 0.0
