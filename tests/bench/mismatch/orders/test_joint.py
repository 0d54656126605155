"""Orders that were found one after another, once all of them are fitted together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.orders.between import FARTHEST, NEXT, Path
from bench.mismatch.orders.joint import Evidence, moved, needless
from bench.mismatch.orders.look import PARTS, Look
from bench.mismatch.orders.revolutions import Revolution, Seen, seen
from bench.mismatch.orders.weak import WeakOrder
from bench.simulation.frame import FloatArray
from tests.bench.mismatch.orders.test_between import NOISE, PRICE, ROWS, shown

TRAIN = np.ones(13, dtype=bool)


def of(*orders: float) -> dict[float, WeakOrder]:
    none = np.zeros(1, dtype=np.complex128)
    return {f: WeakOrder(f, ("1",), none, np.zeros(1), 0.0) for f in orders}


@pytest.mark.parametrize(("true", "fitted"), [(20.46, 20.45), (20.46, 20.475), (12.0, 11.97), (31.0, 31.02)])
def test_an_order_moves_to_where_it_is(true: float, fitted: float) -> None:
    now, revolutions = shown(13, 2.0, np.array([(true, 20.0 * NOISE, 0.4), (7.0, 20.0 * NOISE, 1.0)]), (7.0, fitted))
    steps = moved(now, of(fitted, 7.0), Evidence(revolutions, TRAIN, PRICE))
    assert steps == {fitted: pytest.approx(true, abs=1e-3)}
    assert round(true) != true or steps[fitted] == true


def test_a_whole_order_moves_to_where_it_is_no_whole_one() -> None:
    """Next to a whole number an order is found as that, in some of the revolutions or with the state."""
    now, revolutions = shown(13, 2.0, np.array([(20.04, 20.0 * NOISE, 0.4)]), (20.0,))
    assert moved(now, of(20.0), Evidence(revolutions, TRAIN, PRICE)) == {20.0: pytest.approx(20.04, abs=1e-3)}


def test_a_whole_order_stays_where_noise_turns_its_phases() -> None:
    for seed in range(8):
        now, revolutions = shown(13, 2.0, np.array([(20.0, NOISE, 0.4 + seed)]), (20.0,))
        assert moved(now, of(20.0), Evidence(revolutions, TRAIN, PRICE)) == {}


def test_of_places_where_phases_are_nearly_alike_the_best_is_taken() -> None:
    """Two groups of recordings far from each other: steps from one place to the next miss the best by most of what it
    gains.
    """
    starts = np.array([*(1.1 * k for k in range(6)), *(400.3 + 1.1 * k for k in range(6))])
    theta = 2.0 * np.pi * (starts[:, None] + 1.1 * np.arange(ROWS) / ROWS).ravel()
    places = [slice(k * ROWS, (k + 1) * ROWS) for k in range(starts.size)]
    revolutions = [Revolution(k, rows, 0.0, 0.1, 25.0, 60.0 * k, 1.0, 1.1, 60.0) for k, rows in enumerate(places)]
    looks = [Look(theta[rows], np.ones(ROWS), rows, 2.0 * np.pi * 1.1) for rows in places]
    for true in np.linspace(20.4601, 20.4625, 5):
        y = 20.0 * NOISE * np.cos(true * theta + 0.4) + NOISE * np.random.default_rng(7).normal(size=theta.size)
        off = true - 2.0 / 400.3
        now = seen(looks, revolutions, y, (off,))
        steps = moved(now, of(off), Evidence(revolutions, np.ones(starts.size, dtype=bool), PRICE))
        assert steps == {off: pytest.approx(true, abs=2e-4)}


def test_an_order_that_is_where_it_should_be_stays() -> None:
    now, revolutions = shown(13, 2.0, np.array([(20.25, 20.0 * NOISE, 0.4)]), (20.25,))
    assert moved(now, of(20.25), Evidence(revolutions, TRAIN, PRICE)) == {}


def test_an_order_that_another_was_mistaken_for_is_needless() -> None:
    now, revolutions = shown(13, 2.0, np.array([(20.25, 20.0 * NOISE, 0.4)]), (20.25, 21.0, 40.5))
    assert set(needless(now, of(20.25, 21.0, 40.5), Evidence(revolutions, TRAIN, PRICE))) == {21.0, 40.5}


def test_a_part_of_an_order_is_no_choice_of_one_of_many() -> None:
    """What was found when its neighbour was missing stands a little beside the twelfth that it is."""
    lines = np.array([(23.0 / 3.0, 4.0 * NOISE, 0.4)])
    now, revolutions = shown(13, 2.0, lines, (7.664,))
    assert moved(now, of(7.664), Evidence(revolutions, TRAIN, PRICE)) == {7.664: pytest.approx(92.0 / 12.0, abs=1e-9)}


def test_an_order_leaves_a_place_where_its_phases_are_nearly_alike() -> None:
    """Recordings follow each other in groups that are equally far apart: an order that is off by one over that distance
    has the same phase in all groups.
    """
    apart, travelled, true = 16.0, 1.1, 20.46
    starts = np.array([apart * group + travelled * k for group in range(3) for k in range(4)])
    theta = 2.0 * np.pi * (starts[:, None] + travelled * np.arange(ROWS) / ROWS).ravel()
    y = 20.0 * NOISE * np.cos(true * theta + 0.4) + NOISE * np.random.default_rng(7).normal(size=theta.size)
    places = [slice(k * ROWS, (k + 1) * ROWS) for k in range(starts.size)]
    revolutions = [Revolution(k, rows, 0.0, 0.1, 25.0, 60.0 * k, 1.0, travelled, 60.0) for k, rows in enumerate(places)]
    looks = [Look(theta[rows], np.ones(ROWS), rows, 2.0 * np.pi * travelled) for rows in places]
    off = true + 1.0 / apart
    now = seen(looks, revolutions, y, (off,))
    assert moved(now, of(off), Evidence(revolutions, np.ones(starts.size, dtype=bool), PRICE)) == {
        off: pytest.approx(true, abs=1e-3)
    }


def test_an_order_does_not_move_next_to_one_that_the_simulation_has() -> None:
    """A gearbox's own order that changes with the state looks like two orders next to each other, of which a revolution
    shows only the sum: each then takes what the other leaves, and recordings at other angles are predicted by neither.
    """
    lines = np.array([(20.0, 20.0 * NOISE, 0.4), (20.03, 8.0 * NOISE, 1.0)])
    now, revolutions = shown(13, 2.0, lines, (20.0, 20.1))
    path = Path.of(now, TRAIN, FARTHEST)
    assert np.any(np.abs(20.1 + path.steps - 20.0) <= NEXT)
    steps = moved(now, of(20.1), Evidence(revolutions, TRAIN, PRICE))
    assert all(abs(order - 20.0) > NEXT for order in steps.values())


def test_a_path_keeps_away_from_other_orders_and_keeps_its_place() -> None:
    now, _ = shown(13, 2.0, np.array([(20.0, 20.0 * NOISE, 0.4)]), (20.0,))
    path = Path.of(now, TRAIN, FARTHEST)
    away = path.away_from(20.05, (20.0, 20.05 + 0.5 * NEXT))
    assert 0.0 in away.steps
    moved_to = 20.05 + away.steps[away.steps != 0.0]
    assert np.all(np.abs(moved_to - 20.0) > NEXT)
    assert np.all(np.abs(moved_to - 20.05 - 0.5 * NEXT) > NEXT)
    assert 0 < moved_to.size < path.steps.size - 1


def test_an_order_may_take_the_place_of_a_found_one() -> None:
    """What was first found at the whole order next to it goes when the order itself has been found."""
    lines = np.array([(20.02, 20.0 * NOISE, 0.4)])
    now, revolutions = shown(13, 2.0, lines, (20.0, 20.1))
    steps = moved(now, of(20.0, 20.1), Evidence(revolutions, TRAIN, PRICE))
    # one of two that leak into each other goes there, the other is needless then
    assert steps == {20.0: pytest.approx(20.02, abs=1e-3)}


def test_orders_are_judged_before_what_they_have_passed() -> None:
    """A mode turns an order's phase with the speed: without it the order is one of no phase, and needless."""
    now, revolutions = shown(13, 2.0, np.array([(20.0, 20.0 * NOISE, 0.4)]), (20.0,))
    by = np.exp(2j * np.pi * np.arange(13) / 13.0) * np.linspace(0.5, 3.0, 13)
    passed = replace(now, vectors=now.vectors * by[:, None])
    assert needless(passed, of(20.0), Evidence(revolutions, TRAIN, PRICE)) == [20.0]
    assert needless(passed, of(20.0), Evidence(revolutions, TRAIN, PRICE, lambda _order: by)) == []
    assert moved(passed, of(20.0), Evidence(revolutions, TRAIN, PRICE, lambda _order: by)) == {}


def turning(order: float, turn: float, number: int = 30) -> tuple[Seen, list[Revolution]]:
    """Segments that follow each other at rising loads, with an order whose phase turns by ``turn`` (rad) with the load
    and by a tenth of its square; what is left when it is fitted.
    """
    rng = np.random.default_rng(5)
    load = np.linspace(-1.0, 1.0, number)
    theta = 2.0 * np.pi * 1.1 * np.arange(number * ROWS) / ROWS
    phase = np.repeat(turn * (load + 0.1 * load**2), ROWS)
    y = 20.0 * NOISE * np.cos(order * theta + phase) + NOISE * rng.normal(size=theta.size)
    places = [slice(k * ROWS, (k + 1) * ROWS) for k in range(number)]
    revolutions = [
        Revolution(k, rows, 1000.0 * load[k], 0.1, 25.0, 60.0 * k, 1.0, 1.0, 60.0) for k, rows in enumerate(places)
    ]
    looks = [Look(theta[rows], np.ones(ROWS), rows, 2.0 * np.pi) for rows in places]
    return seen(looks, revolutions, y, (order,)), revolutions


@pytest.mark.parametrize("turn", [1.5, 2.5])
def test_an_order_whose_phase_turns_far_with_the_load_stays(turn: float) -> None:
    """No vectors in proportion to the load say it, and beside it the angle makes the phase run as the load does."""
    now, revolutions = turning(20.0, turn)
    assert moved(now, of(20.0), Evidence(revolutions, np.ones(30, dtype=bool), PRICE)) == {}


def test_what_stands_in_some_segments_alone_is_needless() -> None:
    """A tone is an order at one speed, with another phase in each segment."""
    now, revolutions = turning(20.0, 0.0)
    rng = np.random.default_rng(8)
    few = np.where(np.arange(30) < 4, np.exp(2j * np.pi * rng.random(30)), 0.0)
    tone = replace(now, vectors=20.0 * NOISE * few[:, None] + 0.05 * NOISE * rng.normal(size=(30, 1)))
    assert needless(tone, of(20.0), Evidence(revolutions, np.ones(30, dtype=bool), PRICE)) == [20.0]


def test_an_order_found_beside_one_that_turns_with_the_load_goes_there() -> None:
    now, revolutions = turning(20.0, 2.5)
    beside = 20.0 - 1.0 / PARTS
    now = replace(now, orders=(beside,), vectors=now.vectors * np.exp(1j * (20.0 - beside) * middles(now))[:, None])
    assert moved(now, of(beside), Evidence(revolutions, np.ones(30, dtype=bool), PRICE)) == {beside: 20.0}


def middles(now: Seen) -> FloatArray:
    """Mean angle of the segments, rad."""
    return np.array([rest.theta.mean() for rest in now.rest])
