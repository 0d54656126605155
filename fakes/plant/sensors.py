"""What the encoders, the torque sensor and the thermometers read, with their faults."""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from fakes.plant.faults import INDEX
from fakes.plant.noise import normal

INPUT_ENCODER = INDEX["input_encoder_frozen"]
"""first of the three faults of the input encoder: frozen, jump, wrap"""
LOAD_ENCODER = INDEX["load_encoder_frozen"]
_ABSURD = 10000.0
"""reading of an open PT100 in °C, outside of any range; negative for a short one"""
_SATURATED = INDEX["torque_sensor_saturated"]
_OPEN = INDEX["torque_sensor_open"]
_FROZEN = INDEX["torque_sensor_frozen"]
_DRIFT = INDEX["torque_sensor_drift"]
_GAIN = INDEX["torque_sensor_gain"]
_PT_OPEN = INDEX["pt100_open"]
_PT_SHORT = INDEX["pt100_short"]
_PT_FROZEN = INDEX["pt100_frozen"]
_PT_OFFSET = INDEX["pt100_offset"]
_AMBIENT_OPEN = INDEX["ambient_pt100_open"]
_AMBIENT_SHORT = INDEX["ambient_pt100_short"]


@njit(cache=True, error_model="numpy")
def read_encoder(p: Any, s: Any, angle: float, noise: float, active: Any, faults: Any, first: int) -> int:
    """Return the counts of an encoder, rounded down, at an angle in its drive's frame.

    ``p``, ``s`` are the drive's records; ``first`` is the row of the encoder's frozen fault, jump and wrap follow it.
    """
    if active[first]:
        return int(s.counts)
    counts = int(math.floor(angle * p.encoder_scale + p.encoder_zero + noise))  # noqa: RUF046 (float in numba)
    if active[first + 1]:
        counts += int(faults[first + 1].value)
    if active[first + 2]:
        counts = counts % (1 << int(faults[first + 2].value))
    return counts


@njit(cache=True, error_model="numpy")
def read_torque(p: Any, s: Any, words: Any, active: Any, faults: Any) -> None:
    """Digitise the torque sensor into ``s.torque_adc``: 16 bit over ±10 V, saturated at its ends."""
    noise = p.sensor_noise * normal(words)
    torque = s.sensed_torque * p.sensor_gain
    if active[_GAIN]:
        torque *= faults[_GAIN].value
    torque += p.sensor_zero + noise
    if active[_DRIFT]:
        torque += faults[_DRIFT].value * (s.cycle - faults[_DRIFT].start) * p.cycle_time
    if active[_OPEN]:
        torque = faults[_OPEN].value + noise
    counts = math.floor(torque * p.sensor_counts + 0.5)
    if active[_SATURATED]:
        counts = math.copysign(2.0 * p.sensor_limit, faults[_SATURATED].value)
    if not active[_FROZEN]:
        s.torque_adc = int(min(max(counts, -p.sensor_limit - 1.0), p.sensor_limit))


@njit(cache=True, error_model="numpy")
def read_temperatures(p: Any, s: Any, words: Any, active: Any, faults: Any) -> None:
    """Read both PT100 into ``s.lubricant_reading`` and ``s.ambient_reading``, °C."""
    lubricant = s.sensed_temperature + p.lubricant_offset + p.lubricant_noise * normal(words)
    reading = s.surroundings + p.ambient_offset + p.ambient_noise * normal(words)
    if active[_PT_OFFSET]:
        lubricant += faults[_PT_OFFSET].value
    if active[_PT_OPEN]:
        lubricant = _ABSURD
    if active[_PT_SHORT]:
        lubricant = -_ABSURD
    if active[_AMBIENT_OPEN]:
        reading = _ABSURD
    if active[_AMBIENT_SHORT]:
        reading = -_ABSURD
    if not active[_PT_FROZEN]:
        s.lubricant_reading = lubricant
    s.ambient_reading = reading
