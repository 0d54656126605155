"""An order with a corner over the torque, or one that levels off, is followed between the loads that were driven."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from bench.mismatch.orders.corner import cornered
from bench.mismatch.orders.revolutions import Complex, Revolution, directions, states
from bench.mismatch.orders.series import calibrate
from bench.mismatch.orders.weak import Stage, WeakOrder, design
from bench.simulation.frame import FloatArray

SIZE, NOISE = 1.2e-5, 4e-8
ORDER = 31.0
LOADS = (-1000.0, -450.0, -120.0, 0.0, 120.0, 450.0, 1000.0)


def turns(loads: FloatArray) -> list[Revolution]:
    """A revolution at each load in turn, at speeds and temperatures of its own, in both directions."""
    rng = np.random.default_rng(3)
    side = np.where(np.arange(loads.size) % 2 == 0, 1.0, -1.0)
    speed, warm = rng.choice([0.04, 0.1, 0.18], loads.size), rng.choice([24.0, 33.0, 42.0], loads.size)
    return [
        Revolution(
            k, slice(0, 0), float(loads[k]), float(side[k] * speed[k]), float(warm[k]), 90.0 * k, side[k], 1.0, 60.0
        )
        for k in range(loads.size)
    ]


def levelling(x: FloatArray) -> Complex:
    """An order that grows with the size of the torque and levels off."""
    return np.asarray(
        SIZE * (0.25 + np.tanh(np.abs(x[:, 0]) / 260.0)) * np.exp(1j * (0.8 + 0.3 * np.tanh(x[:, 0] / 400.0)))
    )


def smooth(x: FloatArray) -> Complex:
    """An order that polynomials follow: it grows with the speed, and turns with the torque by more than a radian."""
    return np.asarray(SIZE * (1.0 + 4.0 * np.abs(x[:, 1])) * np.exp(1j * (0.8 + 1.4 * x[:, 0] / 1000.0)))


def asked(vectors_of: Callable[[FloatArray], Complex], times: int) -> WeakOrder | None:
    """What is told of an order whose vectors were seen so many ``times`` at each load."""
    revolutions = turns(np.tile(np.asarray(LOADS), times))
    drawn = np.random.default_rng(5).normal(size=(2, len(revolutions)))
    vectors = vectors_of(states(revolutions)) + NOISE * (drawn[0] + 1j * drawn[1])
    noise = np.full(len(revolutions), NOISE)
    series = calibrate(revolutions, vectors[:, None], noise[:, None], [ORDER], given=())
    stage = Stage(tuple(revolutions), vectors[:, None], np.ones(len(revolutions)), np.full(60, NOISE))
    order = WeakOrder(ORDER, ("1",), np.zeros(1), np.zeros(1), 100.0)
    return cornered(order, stage, vectors, series, noise, np.arange(len(revolutions)))


@pytest.mark.parametrize("times", [2, 6])
def test_an_order_that_levels_off_is_followed_where_no_revolution_was(times: int) -> None:
    found = asked(levelling, times)
    assert found is not None
    assert found.gain == 100.0
    assert {"1", "tau", "abs_tau"} <= set(found.model)
    between = turns(np.linspace(-950.0, 950.0, 39))
    left = found.at(design(found.model, between)) - levelling(states(between))
    assert np.sqrt(np.mean(np.abs(left) ** 2)) < 0.1 * SIZE


def test_polynomials_go_wild_between_the_few_revolutions_that_they_pass_through() -> None:
    revolutions = turns(np.tile(np.asarray(LOADS), 2))
    vectors = levelling(states(revolutions))[:, None]
    series = calibrate(revolutions, vectors, np.full(vectors.shape, NOISE), [ORDER], given=())
    between = turns(np.linspace(-950.0, 950.0, 39))
    left = series.vectors(states(between), directions(between))[:, 0] - levelling(states(between))
    assert np.sqrt(np.mean(np.abs(left) ** 2)) > 0.2 * SIZE


def test_an_order_that_polynomials_follow_keeps_them() -> None:
    assert asked(smooth, 6) is None
