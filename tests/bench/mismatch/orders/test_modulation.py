"""Sidebands: what two orders about a known one have to say more than others."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch.orders.modulation import _beyond_usual, _found, _proportional
from bench.mismatch.orders.revolutions import Complex, Revolution
from bench.simulation.laws import RESONANCE, Law


def test_a_fall_with_the_order_makes_no_order_unusual() -> None:
    place = np.array([2, 5, 10, 20, 50, 100, 200, 300, 400, 500], dtype=np.int64)
    left = _beyond_usual(place, -11.0 - 0.8 * np.log(place))
    assert np.ptp(left) < 0.3 * 0.8 * np.ptp(np.log(place))
    # one that is larger than its place makes it stays so
    size = -11.0 - 0.8 * np.log(place)
    size[4] += 2.0
    own = _beyond_usual(place, size)
    assert int(np.argmax(own)) == 4
    assert own[4] - np.median(own) == pytest.approx(2.0, abs=0.5)


def test_few_orders_tell_no_fall() -> None:
    place = np.array([18, 20], dtype=np.int64)
    size = np.array([-11.0, -12.0])
    assert _beyond_usual(place, size) == pytest.approx(size, abs=0.05)


@pytest.mark.parametrize("known", [True, False])
def test_what_passes_the_same_mode_is_no_sideband_of_each_other(known: bool) -> None:
    """Orders 137 and 139 follow 138 through a resonance, and are constant before it."""
    speeds = np.array([0.03, 0.06, 0.09, 0.12, 0.15, 0.18])
    revolutions = [Revolution(0, slice(0, 0), 0.0, v, 25.0, 0.0, 1.0, 1.0, 60.0) for v in speeds]
    natural, damping, share = 12.0, 0.1, 0.4
    swing = {
        f: 1.0 / (1.0 - (f * speeds / natural) ** 2 + 2j * damping * f * speeds / natural) for f in (137, 138, 139)
    }
    rng = np.random.default_rng(2)
    noise = 0.01
    shown = {
        f: 1.0 + share * (h - 1.0) + noise * (rng.normal(size=6) + 1j * rng.normal(size=6)) for f, h in swing.items()
    }
    law = Law(
        RESONANCE,
        "second_order",
        (natural, damping, share),
        0.0,
        (137.0, 138.0, 139.0),
        np.ones(3, dtype=np.complex128),
    )
    periodic = SimpleNamespace(
        series=SimpleNamespace(orders=(137.0, 138.0, 139.0)),
        laws=(law,) if known else (),
        at_revolutions=lambda _turns, orders: np.column_stack([shown[round(f)] for f in orders]),
    )
    model = SimpleNamespace(
        periodic=periodic, training_revolutions=revolutions, given=SimpleNamespace(orders=(138.0,), notch=())
    )
    sight = SimpleNamespace(
        found=(137.0, 139.0),
        stage=SimpleNamespace(scale=np.ones(6)),
        noise=lambda _order: noise,
        at=lambda _model, order: shown[round(order)],
        gains=lambda vectors, _order: (_proportional(vectors, np.ones(6, dtype=np.complex128), noise), 0),
        estimated=lambda vectors, *_: SimpleNamespace(model=("1",), at=lambda x: x[:, 0] * np.mean(vectors)),
    )
    found = _found(cast("Any", model), cast("Any", sight), ())
    assert bool(found.following.min() > 3.0) is not known
    assert bool(np.abs(found.following).max() < 3.0) is known


@pytest.mark.parametrize(("slopes", "alike"), [((0.35, 0.35), True), ((0.35, -0.35), False)])
def test_sides_that_move_alike_with_the_load_may_be_a_pair(slopes: tuple[float, float], alike: bool) -> None:
    """Neither is constant, and neither follows the carrier, which is so."""
    loads = np.linspace(-800.0, 800.0, 12)
    revolutions = [Revolution(0, slice(0, 0), load, 0.1, 25.0, 0.0, 1.0, 1.0, 60.0) for load in loads]
    rng = np.random.default_rng(2)
    noise = 0.01
    size = dict(zip((91, 93), (1.0 + slope * loads / 1000.0 for slope in slopes), strict=True)) | {92: np.ones(12)}
    shown = {f: v * np.exp(1j * f) + noise * (rng.normal(size=12) + 1j * rng.normal(size=12)) for f, v in size.items()}
    x = np.column_stack([np.ones(12), loads / 1000.0])

    def line(vectors: Complex) -> Complex:
        return np.asarray(x @ np.linalg.lstsq(x.astype(np.complex128), vectors, rcond=None)[0])

    model = SimpleNamespace(
        periodic=SimpleNamespace(
            series=SimpleNamespace(orders=(92.0,)),
            laws=(),
            at_revolutions=lambda _turns, orders: np.column_stack([shown[round(f)] for f in orders]),
        ),
        training_revolutions=revolutions,
        given=SimpleNamespace(orders=(92.0,), notch=()),
    )
    sight = SimpleNamespace(
        found=(91.0, 93.0),
        stage=SimpleNamespace(scale=np.ones(12)),
        noise=lambda _order: noise,
        at=lambda _model, order: shown[round(order)],
        gains=lambda vectors, _order: (_proportional(vectors, line(vectors), noise), 2),
        estimated=lambda vectors, *_: SimpleNamespace(model=("1",), at=lambda _x: line(vectors)),
    )
    found = _found(cast("Any", model), cast("Any", sight), ())
    assert found.constant.max() < -10.0
    assert found.following.max() < -10.0
    assert bool(found.together[0, 1] > -3.0) is alike
