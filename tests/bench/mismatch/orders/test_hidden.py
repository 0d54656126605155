"""Orders between the whole ones that these hide."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.orders.hidden import unhide
from bench.mismatch.orders.joint import Evidence
from bench.mismatch.orders.weak import WeakOrder, search
from bench.simulation.frame import FloatArray
from tests.bench.mismatch.orders.test_between import NOISE, PRICE, shown

EVERY_OTHER = np.arange(16) % 2 == 0


def found_whole(waves: FloatArray, travelled: float) -> dict[float, WeakOrder]:
    """Whole orders that are found one after another in every other of sixteen segments."""
    found: dict[float, WeakOrder] = {}
    while True:
        now, revolutions = shown(16, travelled, waves, tuple(sorted(found)))
        fresh = search(now, revolutions, EVERY_OTHER, now.orders, NOISE, PRICE)
        if not fresh:
            return found
        found |= {line.order: line for line in fresh}


def unhidden(waves: FloatArray, travelled: float) -> tuple[set[float], dict[float, WeakOrder]]:
    found = found_whole(waves, travelled)
    before = set(found)
    now, revolutions = shown(16, travelled, waves, tuple(sorted(found)))
    put = unhide(now, (), found, Evidence(revolutions, EVERY_OTHER, PRICE))
    assert put == (set(found) != before)
    return before, found


@pytest.mark.parametrize("travelled", [1.0, 1.02])
def test_an_order_that_leaks_into_two_whole_ones_takes_their_place(travelled: float) -> None:
    before, found = unhidden(np.array([(88.5, 4.0 * NOISE, 0.4), (60.0, 2.0 * NOISE, 1.1)]), travelled)
    assert before & {88.0, 89.0}
    assert [f for f in found if abs(f - 88.5) < 1.0] == [88.5]
    assert found[88.5].amplitude == pytest.approx(4.0 * NOISE, rel=0.1)
    assert 60.0 in found


@pytest.mark.parametrize("travelled", [1.0, 1.02])
@pytest.mark.parametrize(
    "waves", [[(88.0, 2.0 * NOISE, 0.4), (92.0, NOISE, 1.1)], [(88.0, 4.0 * NOISE, 0.4), (89.0, 3.0 * NOISE, 1.1)]]
)
def test_whole_orders_stay_where_they_are(waves: list[tuple[float, float, float]], travelled: float) -> None:
    before, found = unhidden(np.array(waves), travelled)
    assert set(found) == before == {f for f, _, _ in waves}


NOTHING = WeakOrder(88.0, ("1",), np.zeros(1, dtype=np.complex128), np.zeros(1), 0.0)


def beside_known(order: float, travelled: float, known: tuple[float, ...]) -> list[float]:
    """What is in the place of 88, which was found where an ``order`` acts beside ``known`` ones of the simulation."""
    waves = np.array([(order, 20.0 * NOISE, 0.4), *((f, 10.0 * NOISE, 1.0) for f in known)])
    now, revolutions = shown(16, travelled, waves, (88.0, *known))
    found = {88.0: NOTHING}
    put = unhide(now, known, found, Evidence(revolutions, np.ones(16, dtype=bool), PRICE))
    assert put == (set(found) != {88.0})
    return sorted(found)


@pytest.mark.parametrize("part", range(1, 12))
@pytest.mark.parametrize("travelled", [1.02, 1.05])
def test_beside_orders_of_the_simulation_the_other_side_tells_the_place(part: int, travelled: float) -> None:
    """What the simulation's own order is alone nobody knows: its vectors are not asked."""
    order = 88.0 - part / 12.0
    assert beside_known(order, travelled, (87.0, 89.0)) == [order]
    if travelled == 1.05:
        assert beside_known(order, travelled, (87.0,)) == [order]


@pytest.mark.parametrize("part", range(1, 12))
def test_revolutions_that_begin_at_one_angle_do_not_tell_the_side(part: int) -> None:
    assert beside_known(88.0 - part / 12.0, 1.0, (87.0, 89.0)) == [88.0]


@pytest.mark.parametrize("known", [(87.0,), (87.0, 89.0)])
def test_beside_an_order_of_the_simulation_none_is_put_that_nothing_hides(known: tuple[float, ...]) -> None:
    assert beside_known(88.0 - 1.0 / 12.0, 2.0, known) == [88.0]


def test_an_order_that_whole_ones_do_not_take_is_not_hidden_by_them() -> None:
    """Over two whole revolutions 88.5 leaves nothing in 88 or 89, and stands in the residual for all to see."""
    now, revolutions = shown(16, 2.0, np.array([(88.5, 4.0 * NOISE, 0.4)]), (88.0, 89.0))
    none = np.zeros(1, dtype=np.complex128)
    taken = {f: WeakOrder(f, ("1",), none, np.zeros(1), 0.0) for f in (88.0, 89.0)}
    assert not unhide(now, (), taken, Evidence(revolutions, EVERY_OTHER, PRICE))


def test_it_is_the_same_when_the_shaft_turns_back() -> None:
    waves = np.array([(88.5, 4.0 * NOISE, 0.4)])
    now, revolutions = shown(16, -1.0, waves, (88.0, 89.0))
    none = np.zeros(1, dtype=np.complex128)
    found = {f: WeakOrder(f, ("1",), none, np.zeros(1), 0.0) for f in (88.0, 89.0)}
    assert unhide(now, (), found, Evidence(revolutions, EVERY_OTHER, PRICE))
    assert set(found) == {88.5}
