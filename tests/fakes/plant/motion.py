"""Set values for plants under test, and the channels in the bench's frame."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fakes.plant import COMMAND_DTYPE, MODE_TORQUE, MODE_VELOCITY, Plant, PlantTruth

CYCLE = 0.0005


def commands(seconds: float, omega: float = 0.0, torque: float = 0.0) -> NDArray[Any]:
    """Both drives on: input at ``omega`` rad/s, load motor ``torque`` N·m opposing +q (rh380n's drive frame)."""
    rows = np.zeros(round(seconds / CYCLE), COMMAND_DTYPE)
    rows["input_enable"] = rows["load_enable"] = 1
    rows["input_mode"], rows["load_mode"] = MODE_VELOCITY, MODE_TORQUE
    rows["input_velocity"], rows["load_torque"] = omega, torque
    return rows


def ramped(seconds: float, start: float, stop: float, torque_start: float, torque_stop: float) -> NDArray[Any]:
    """Velocity and torque going linearly from start to stop."""
    rows = commands(seconds)
    share = np.arange(1, rows.size + 1) / rows.size
    rows["input_velocity"] = start + share * (stop - start)
    rows["load_torque"] = torque_start + share * (torque_stop - torque_start)
    return rows


def bring_up(plant: Plant, omega: float, torque: float, settle: float = 1.0) -> None:
    """Ramp to a steady state and let it settle."""
    plant.step(ramped(1.0, 0.0, omega, 0.0, torque))
    plant.step(commands(settle, omega, torque))


def quiet(truth: PlantTruth) -> PlantTruth:
    """Return the truth without noise, ripple and torque offset, and with encoders so fine that they do not disturb."""
    return replace(
        truth,
        ripple=(),
        input_motor=replace(truth.input_motor, torque_offset=0.0),
        input_drive=replace(truth.input_drive, torque_noise=0.0, torque_resolution=1e-9),
        load_drive=replace(truth.load_drive, torque_noise=0.0, torque_resolution=1e-9),
        input_encoder=replace(truth.input_encoder, bits=34, noise=0.0),
        load_encoder=replace(truth.load_encoder, bits=40, noise=0.0),
        torque_sensor=replace(truth.torque_sensor, noise=0.0, zero=0.0),
    )


def smooth(truth: PlantTruth) -> PlantTruth:
    """Return the truth with a transmission error of its elastic part only."""
    series = truth.transmission_error
    return replace(
        truth,
        transmission_error=replace(
            series,
            amplitude=np.zeros_like(series.amplitude),
            phase=np.zeros_like(series.phase),
            offset=np.zeros_like(series.offset),
        ),
    )
