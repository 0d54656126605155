"""Orders that stand in the revolutions beside those that are fitted already."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.orders.turns import Complex, Seen, Turn
from bench.mismatch.orders.weak import search

ORDERS = 61
NOISE = 1e-7
TURNS = 14


@pytest.mark.parametrize(("fitted", "found"), [((10.5,), [10.0]), ((9.75,), [10.0]), ((10.0,), [])])
def test_a_whole_order_is_found_beside_a_fitted_one_that_is_none(fitted: tuple[float, ...], found: list[float]) -> None:
    """Of an order that is fitted nothing is left; of its neighbour everything."""
    rng = np.random.default_rng(5)
    turns = [Turn(k, slice(0, 0), 100.0 * (k % 5), 0.1, 25.0 + k % 3, 0.0, 1.0, 1.0, 60.0) for k in range(TURNS)]
    drawn = rng.normal(size=(2, TURNS, ORDERS))
    left: Complex = np.asarray(NOISE * (drawn[0] + 1j * drawn[1]), dtype=np.complex128)
    left[:, 10] += 2e-6
    vectors = np.full((TURNS, len(fitted)), 5e-6 + 0j)
    seen = Seen(fitted, vectors, left, np.full((TURNS, ORDERS), NOISE), np.full(TURNS, 4e-6), ())
    shown = search(seen, turns, np.ones(TURNS, dtype=bool), fitted, 4e-6, 15.0)
    assert [w.order for w in shown] == found
