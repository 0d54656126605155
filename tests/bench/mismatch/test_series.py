"""The series as it is summed: its slope, and the waves its amplitudes are read with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.series import Scaling, Series
from bench.mismatch.spectrum import waves
from tests.bench.mismatch.synthetic import torques

ORDERS = (1.0, 24.0, 276.0, 2.5, 4440.0)


def test_waves_of_whole_and_other_orders() -> None:
    theta = np.linspace(-300.0, -290.0, 1001)
    angle = theta[:, None] * np.array([0.0, *ORDERS])
    assert waves(theta, (0.0, *ORDERS)) == pytest.approx(np.hstack([np.cos(angle), np.sin(angle)]), abs=1e-10)


def test_the_slope_is_the_difference_to_either_side() -> None:
    rng = np.random.default_rng(4)
    frame = torques().slow["motor_torque"].frame
    scaling = Scaling(np.array([0.0, 0.1, 30.0]), np.array([500.0, 0.05, 10.0]))
    sides = (1, -1)
    shape = (len(ORDERS), 10)
    series = Series(
        ORDERS,
        dict.fromkeys(sides, scaling),
        {side: rng.normal(0.0, 1e-6, shape) for side in sides},
        {side: rng.normal(0.0, 0.3, shape) for side in sides},
        np.zeros(len(ORDERS)),
        np.ones(18),
        np.zeros(len(ORDERS)),
    )
    h = 3e-4
    ahead, behind = (series.evaluate(replace(frame, theta=frame.theta + step)) for step in (h, -h))
    assert series.slope(frame, h) == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-8)
    x = np.column_stack([frame.torque, frame.velocity, frame.temperature])
    vectors = series.vectors(x, frame.last_direction)
    angle = frame.theta[:, None] * np.asarray(ORDERS)
    expected = np.sum(vectors.real * np.sin(angle) + vectors.imag * np.cos(angle), axis=1)
    assert series.evaluate(frame) == pytest.approx(expected, abs=1e-11)
