"""Which laws of amplitudes are asked for: those that say more than the series' own polynomials."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.orders.law_scores import Amplitudes, factors
from bench.mismatch.orders.series import calibrate
from bench.mismatch.orders.turns import Turn
from bench.simulation.laws import Reference

ORDERS = (1.0, 4.0)
NOISE = 1e-8


def amplitudes(speeds: tuple[float, ...]) -> Amplitudes:
    """Revolutions both ways at some speeds, each at five loads."""
    turns = [
        Turn(0, slice(0, 0), load, side * speed, 25.0, 0.0, side, 1.0, 60.0)
        for side in (1.0, -1.0)
        for speed in speeds
        for load in (-800.0, -400.0, 0.0, 400.0, 800.0)
    ]
    vectors = np.full((len(turns), len(ORDERS)), 1e-5 + 0j)
    noise = np.full(vectors.shape, NOISE)
    x = np.array([[t.torque, t.velocity, t.temperature] for t in turns])
    time = np.arange(len(turns), dtype=np.float64)
    series = calibrate(turns, vectors, noise, ORDERS)
    direction = np.array([t.direction for t in turns])
    return Amplitudes(vectors, noise, x, direction, time, ORDERS, series, Reference.of(x, time))


@pytest.mark.parametrize(("speeds", "asked"), [((0.1, 0.17), False), ((0.02, 0.04, 0.06, 0.09, 0.13, 0.17), True)])
def test_two_speeds_are_a_straight_line(speeds: tuple[float, ...], asked: bool) -> None:
    tried = {law.effect for law in factors(amplitudes(speeds))}
    assert ("te.velocity_nonlinear" in tried) is asked
