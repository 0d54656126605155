"""Weak orders that pass a strong mode: found under it, each once, and told from what an encoder misreads."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch.orders.revolutions import Complex, Revolution, directions, states
from bench.mismatch.orders.under_mode import _significant, hides, passes
from bench.mismatch.orders.weak import Stage
from bench.simulation.frame import FloatArray
from bench.simulation.laws import RESONANCE, Law, resonant

SPEEDS, NOISE, HIGHEST = (0.052, 0.105, 0.175), 2e-8, 420
LAW = Law(RESONANCE, "second_order", (17.1, 0.056, 0.72), 0.0, (), np.zeros(0, dtype=np.complex128))
WEAK = (8.0, 36.0, 111.0, 185.0, 230.0, 322.0, 370.0)
PRICE = 14.0
"""gain of log-likelihood that the best of a thousand orders of noise does not reach once in a hundred folders"""
TURNS = tuple(
    Revolution(0, slice(0, 0), load, side * speed, 25.0, 0.0, side, 1.0, 60.0)
    for side in (1.0, -1.0)
    for speed in SPEEDS
    for load in (-800.0, -300.0, 0.0, 300.0, 800.0)
)


def response(orders: FloatArray) -> Complex:
    return resonant(LAW.form, states(TURNS)[:, 1][:, None] * orders[None, :], LAW.point)


def stage(seed: int, through: bool = True) -> Stage:
    """Revolutions in which the weak orders stand, one vector in each direction, ``through`` the mode or beside it."""
    rng = np.random.default_rng(seed)
    shape = (len(TURNS), HIGHEST + 1)
    vectors = NOISE * (rng.normal(size=shape) + 1j * rng.normal(size=shape))
    side = directions(TURNS)[:, None]
    own = [4e-6 * np.exp(2j * np.pi * rng.random(len(WEAK))) for _ in range(2)]
    orders = np.asarray(WEAK)
    vectors[:, orders.astype(int)] += np.where(side > 0, own[0], own[1]) * (response(orders) if through else 1.0)
    return Stage(TURNS, vectors, np.ones(len(TURNS)), np.full(HIGHEST + 1, NOISE))


def found(own: Stage, law: Law) -> dict[float, Any]:
    orders = np.arange(HIGHEST + 1, dtype=np.float64)
    return {w.order: w for w in _significant(own, own.vectors, orders, law, (), 1e-6, PRICE)}


@pytest.mark.parametrize("seed", range(8))
def test_under_the_mode_every_order_is_found_and_no_other(seed: int) -> None:
    under = found(stage(seed), LAW)
    assert sorted(under) == sorted(WEAK)
    assert all(w.model == ("p", "n") for w in under.values())
    beside = found(stage(seed), Law(RESONANCE, "second_order", (17.1, 0.056, 0.0), 0.0, (), LAW.strength))
    assert sum(w.gain for w in under.values()) > sum(w.gain for w in beside.values()) + 100.0


def test_what_is_fitted_already_is_not_found_again() -> None:
    own = stage(1)
    left = _significant(own, own.vectors, np.arange(HIGHEST + 1.0), LAW, WEAK[:3], 1e-6, PRICE)
    assert sorted(w.order for w in left) == sorted(WEAK[3:])


@pytest.mark.parametrize("through", [True, False])
def test_an_encoder_s_order_does_not_pass_the_mode(through: bool) -> None:
    own = stage(2, through)
    model: Any = SimpleNamespace(
        seen=SimpleNamespace(vectors=own.vectors, orders=tuple(np.arange(HIGHEST + 1.0))),
        train=np.ones(len(TURNS), dtype=bool),
        laws=(LAW,),
    )
    assert passes(model, own, 185.0) is through


@pytest.mark.parametrize(("weak", "size", "hidden"), [(1, 1e-9, True), (0, 1e-9, False), (0, 1e-4, True)])
def test_a_mode_hides_orders_where_some_are_not_under_it_or_where_it_is_strong(
    weak: int, size: float, hidden: bool
) -> None:
    orders = (46.0, 92.0)
    law = Law(RESONANCE, "second_order", LAW.point, 0.0, orders, np.ones(2), series=orders)
    series = SimpleNamespace(orders=orders, vectors=lambda x, side: np.full((len(x), 2), size + 0j))
    model: Any = SimpleNamespace(
        noise=SimpleNamespace(variance=1e-12),
        periodic=SimpleNamespace(weak=(None,) * weak),
        training_revolutions=list(TURNS),
    )
    assert hides(model, cast("Any", SimpleNamespace(law=law, series=series))) is hidden
