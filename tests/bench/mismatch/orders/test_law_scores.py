"""Which laws of amplitudes are asked for: those that say more than the series' own polynomials."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.orders.law_scores import Amplitudes, changes_of, factors, whitened
from bench.mismatch.orders.revolutions import Revolution
from bench.mismatch.orders.series import calibrate
from bench.simulation.laws import Reference

ORDERS = (1.0, 4.0)
NOISE = 1e-8


def amplitudes(speeds: tuple[float, ...]) -> Amplitudes:
    """Revolutions both ways at some speeds, each at five loads."""
    revolutions = [
        Revolution(0, slice(0, 0), load, side * speed, 25.0, 0.0, side, 1.0, 60.0)
        for side in (1.0, -1.0)
        for speed in speeds
        for load in (-800.0, -400.0, 0.0, 400.0, 800.0)
    ]
    vectors = np.full((len(revolutions), len(ORDERS)), 1e-5 + 0j)
    noise = np.full(vectors.shape, NOISE)
    x = np.array([[t.torque, t.velocity, t.temperature] for t in revolutions])
    time = np.arange(len(revolutions), dtype=np.float64)
    series = calibrate(revolutions, vectors, noise, ORDERS)
    direction = np.array([t.direction for t in revolutions])
    return Amplitudes(vectors, noise, x, direction, time, ORDERS, series, Reference.of(x, time))


@pytest.mark.parametrize(("speeds", "asked"), [((0.1, 0.17), False), ((0.02, 0.04, 0.06, 0.09, 0.13, 0.17), True)])
def test_two_speeds_are_a_straight_line(speeds: tuple[float, ...], asked: bool) -> None:
    tried = {law.effect for law in factors(amplitudes(speeds))}
    assert ("te.velocity_nonlinear" in tried) is asked


@pytest.mark.parametrize(
    ("orders", "regular"),
    [((1.0, 4.0), [True, True]), ((1.0, 4.5), [True, False]), ((4.0, 4.5), [False, False])],
)
def test_laws_are_asked_of_whole_orders_that_nothing_leaks_into(
    orders: tuple[float, float], regular: list[bool]
) -> None:
    """The phase of an order that is known to some digits only moves with the distance run, and so with time."""
    data = amplitudes((0.02, 0.04, 0.06, 0.09, 0.13, 0.17))
    data = replace(data, orders=orders, series=replace(data.series, orders=orders))
    assert data.regular.tolist() == regular
    law = next(law for law in factors(data) if law.effect == "te.drift_time")
    (changes,) = changes_of(data, whitened(data)[0], [law])
    assert (np.abs(changes).max(axis=(1, 2)) > 0.0).tolist() == regular


def test_a_temperature_that_stays_as_it_is_has_no_law() -> None:
    """Rounding differs from revolution to revolution, and is no variation that a polynomial could not say."""
    data = amplitudes((0.02, 0.04, 0.06, 0.09, 0.13, 0.17))
    x = data.x.copy()
    x[:, 2] = 25.0 * (1.0 + 1e-16 * np.arange(len(x)))
    assert "te.temperature_nonlinear" not in {law.effect for law in factors(replace(data, x=x))}
    x[:, 2] = 25.0 + 10.0 * np.sin(np.arange(len(x)))
    assert "te.temperature_nonlinear" in {law.effect for law in factors(replace(data, x=x))}
