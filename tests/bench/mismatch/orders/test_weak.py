"""Orders that stand in the revolutions beside those that are fitted already."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.criteria import LEAST_POWER
from bench.mismatch.orders.between import search_between
from bench.mismatch.orders.look import Rest
from bench.mismatch.orders.revolutions import HIGHEST_BETWEEN, Complex, Revolution, Seen
from bench.mismatch.orders.weak import Stage, search
from bench.simulation.frame import FloatArray

ORDERS = 61
NOISE = 1e-7
TURNS = 14


@pytest.mark.parametrize(
    ("fitted", "floor", "found"),
    [
        ((10.5,), 4e-6, [10.0]),
        ((9.75,), 4e-6, [10.0]),
        ((10.0,), 4e-6, []),
        # what is left of it is less than what is told, unless a neighbour has taken a part
        ((9.75,), 6.3e-5, [10.0]),
        ((20.5,), 6.3e-5, []),
    ],
)
def test_a_whole_order_is_found_beside_a_fitted_one_that_is_none(
    fitted: tuple[float, ...], floor: float, found: list[float]
) -> None:
    """Of an order that is fitted nothing is left; of its neighbour everything."""
    rng = np.random.default_rng(5)
    revolutions = [
        Revolution(k, slice(0, 4000), 100.0 * (k % 5), 0.1, 25.0 + k % 3, 0.0, 1.0, 1.0, 60.0) for k in range(TURNS)
    ]
    drawn = rng.normal(size=(2, TURNS, ORDERS))
    left: Complex = np.asarray(NOISE * (drawn[0] + 1j * drawn[1]), dtype=np.complex128)
    left[:, 10] += 2e-6
    vectors = np.full((TURNS, len(fitted)), 5e-6 + 0j)
    seen = Seen(fitted, vectors, left, np.full((TURNS, ORDERS), NOISE), np.full(TURNS, 4e-6), ())
    shown = search(seen, revolutions, np.ones(TURNS, dtype=bool), fitted, floor, 15.0)
    assert [w.order for w in shown] == found


@pytest.mark.parametrize(("rows", "found"), [(100, []), (130, [60.0])])
def test_an_order_beyond_half_the_rows_of_a_revolution_waits_for_lower_ones(rows: int, found: list[float]) -> None:
    """It may be the shadow of one."""
    rng = np.random.default_rng(5)
    revolutions = [
        Revolution(k, slice(0, rows), 100.0 * (k % 5), 0.1, 25.0 + k % 3, 0.0, 1.0, 1.0, 20.0 * np.pi)
        for k in range(TURNS)
    ]
    drawn = rng.normal(size=(2, TURNS, ORDERS))
    left: Complex = np.asarray(NOISE * (drawn[0] + 1j * drawn[1]), dtype=np.complex128)
    left[:, 60] += 2e-6
    seen = Seen(
        (), np.zeros((TURNS, 0), dtype=complex), left, np.full((TURNS, ORDERS), NOISE), np.full(TURNS, 4e-6), ()
    )
    train = np.ones(TURNS, dtype=bool)
    stage = Stage.of(seen, revolutions, train)
    assert stage is not None
    assert stage.highest == pytest.approx(rows / 2.0)
    assert [w.order for w in search(seen, revolutions, train, (), 1e-7, 15.0, stage.highest)] == found
    assert [w.order for w in search(seen, revolutions, train, (), 1e-7, 15.0)] == [60.0]


def of_lengths(count: int) -> tuple[list[Revolution], list[FloatArray]]:
    """Turns of a little more than a revolution each, from any angle on; their angles (n,)."""
    rng = np.random.default_rng(7)
    revolutions, angles = [], []
    for k in range(count):
        length = 2.0 * np.pi * rng.uniform(1.03, 1.2)
        revolutions.append(
            Revolution(k, slice(0, 4000), 100.0 * (k % 5), 0.1, 25.0 + k % 3, 0.0, 1.0, 1.0, length / 0.1)
        )
        angles.append(rng.uniform(0.0, 40.0) + np.linspace(0.0, length, 4000))
    return revolutions, angles


def test_an_order_of_which_fitted_neighbours_take_nearly_all_is_found() -> None:
    """Half an order from two that are fitted: over one revolution they are nearly the same as it."""
    fitted, size = (91.0, 92.0, 92.25), 1e-6
    revolutions, angles = of_lengths(TURNS)
    rests, vectors = [], []
    rng = np.random.default_rng(8)
    for theta in angles:
        y = size * np.cos(91.5 * theta) + NOISE * rng.normal(size=theta.size)
        columns = np.column_stack([w(f * theta) for f in fitted for w in (np.sin, np.cos)])
        beta = np.linalg.lstsq(columns, y, rcond=None)[0]
        rest = y - columns @ beta
        vectors.append(beta[0::2] + 1j * beta[1::2])
        rests.append(Rest(theta, rest, float(theta.size)))
    left = np.zeros((TURNS, HIGHEST_BETWEEN + 1), dtype=np.complex128)
    noise = np.full(left.shape, NOISE * np.sqrt(2.0 / 4000.0))
    known = np.asarray(vectors, dtype=np.complex128)
    seen = Seen(fitted, known, left, noise, np.full(TURNS, NOISE), tuple(rests))
    train = np.ones(TURNS, dtype=bool)
    stage = Stage.of(seen, revolutions, train)
    assert stage is not None
    # as large as the least that is told, but for a part that the neighbours have not taken
    floor = 0.9 * size / np.sqrt(2.0 * LEAST_POWER)
    assert stage.share(91.5, fitted) < 0.2
    assert stage.share(60.0, fitted) == 1.0
    found = search_between(seen, revolutions, train, fitted, floor, 15.0)
    assert [w.order for w in found] == [91.5]
