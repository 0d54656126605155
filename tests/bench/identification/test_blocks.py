"""Blocks of 50 ms: torque, speed and acceleration of the same instants, and only what moves from end to end."""

from __future__ import annotations

import numpy as np
import pytest

from bench.identification.samples.blocks import Blocks, make_blocks
from bench.identification.samples.motion import moving

RATE = 2000.0
INERTIA, VISCOUS, HOLDING = 0.0029, 0.006, 0.9


def _ramp(rest_s: float) -> Blocks:
    """A shaft that rests, held by a torque of its own, and then speeds up by 40 rad/s²."""
    time = np.arange(2000) / RATE
    since = np.maximum(time - rest_s, 0.0)
    angle, omega = 20.0 * since**2, 40.0 * since
    torque = np.where(since > 0.0, INERTIA * 40.0 + VISCOUS * omega, -HOLDING)
    channels = {"time": time, "motor_angle": angle, "motor_torque": torque}
    return make_blocks(channels, RATE, np.zeros(time.size, dtype=bool), np.empty(0, dtype=np.int64))


def test_torque_speed_and_acceleration_are_of_the_same_instant() -> None:
    """Half a sample between them is 0.05 % of the inertia by way of the viscous friction."""
    b = _ramp(0.0)
    inertia = (b.motor_torque - VISCOUS * b.motor_velocity) / b.acceleration
    assert inertia[2:] == pytest.approx(INERTIA, rel=1e-6)


@pytest.mark.parametrize("rest_s", [0.2, 0.21, 0.225, 0.2399, 0.249])
def test_rows_that_touch_standstill_are_left_out(rest_s: float) -> None:
    b = _ramp(rest_s)
    rows = moving(b)
    assert 8 <= rows.sum() <= 14
    left = b.motor_torque - VISCOUS * b.motor_velocity - INERTIA * b.acceleration
    assert left[rows] == pytest.approx(0.0, abs=1e-9)
