"""The transmission error is searched again where a tone may have made orders, and only there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch import transmission
from bench.mismatch.discovery import NAMED, UNKNOWN, UNNAMED, Discovery
from bench.mismatch.transmission import Task
from bench.mismatch.unnamed import following
from bench.simulation.terms import TRANSMISSION_ERROR

TAKEN = object()


def searched(
    monkeypatch: pytest.MonkeyPatch, heard: bool, doubtful: tuple[float, ...], left: tuple[float, ...]
) -> tuple[list[Any], list[str]]:
    """What is taken off in each search of orders 7, 250, 252, of which a second one has those ``left``; its notes."""
    taken: list[Any] = []

    def once(_task: Task, tone: Any = None, known: Any = None) -> tuple[Any, Any, Any]:
        taken.append(tone)
        orders = (7.0, 250.0, 252.0) if tone is None else left
        periodic = SimpleNamespace(series=SimpleNamespace(orders=orders), weak=())
        model = SimpleNamespace(periodic=periodic, offset=SimpleNamespace(close=lambda: None), known=known)
        return model, SimpleNamespace(notes=[]), SimpleNamespace(frequency=2.91) if heard else None

    monkeypatch.setattr(Task, "_once", once)
    monkeypatch.setattr(transmission, "misleading", lambda _: None)
    monkeypatch.setattr(following, "search", lambda *_: None)
    monkeypatch.setattr(transmission, "made_by_tone", lambda *_: doubtful)
    monkeypatch.setattr(transmission, "tone_on_rows", lambda *_: TAKEN)
    nothing = cast("Any", None)
    _, outcome = Task(nothing, nothing, nothing, (), (), (), True, 0).searched()
    return taken, outcome.notes


def test_orders_that_are_gone_without_the_tone_are_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    taken, notes = searched(monkeypatch, True, (250.0, 252.0), (7.0, 251.9))
    assert taken == [None, TAKEN]
    assert notes == ["no order at 250: what acted there was the tone of 2.91 Hz, with which it is gone"]


def test_orders_that_stay_are_no_tones(monkeypatch: pytest.MonkeyPatch) -> None:
    taken, notes = searched(monkeypatch, True, (250.0,), (7.0, 250.0, 252.0))
    assert taken == [None, TAKEN]
    assert notes == []


@pytest.mark.parametrize(("heard", "doubtful"), [(False, (250.0,)), (True, ())])
def test_without_a_tone_that_may_have_made_orders_nothing_is_searched_twice(
    monkeypatch: pytest.MonkeyPatch, heard: bool, doubtful: tuple[float, ...]
) -> None:
    assert searched(monkeypatch, heard, doubtful, ()) == ([None], [])


@pytest.mark.parametrize(("less", "taken"), [(0.5, True), (2.0, False)])
def test_an_offset_that_misled_the_orders_is_taken_off_if_less_is_left_then(
    monkeypatch: pytest.MonkeyPatch, less: float, taken: bool
) -> None:
    """The second search knows the offset of the first; of both the one that leaves less counts."""
    offset, closed = SimpleNamespace(states=False), []

    def once(_task: Task, tone: Any = None, known: Any = None) -> tuple[Any, Any, Any]:
        assert tone is None
        model = SimpleNamespace(offset=SimpleNamespace(close=lambda: closed.append(known)), known=known)
        return model, SimpleNamespace(left=1.0 if known is None else less), None

    monkeypatch.setattr(Task, "_once", once)
    monkeypatch.setattr(transmission, "misleading", lambda _: offset)
    monkeypatch.setattr(following, "search", lambda *_: None)
    monkeypatch.setattr(transmission, "_leaves_less", lambda one, other: one.left < other.left)
    nothing = cast("Any", None)
    model, _ = Task(nothing, nothing, nothing, (), (), (), True, 0).searched()
    assert (cast("Any", model).known is offset) == taken
    assert closed == [None]  # two banks never stand side by side


def of_orders(effect: str, status: str, orders: tuple[float, ...], size: float) -> Discovery:
    """A discovery of some orders that adds ``size`` to each of ten rows."""
    described = (effect, status, 0.9, TRANSMISSION_ERROR, effect, effect, ("temperature",))
    return Discovery(*described, (), np.full(10, size), 50.0, 0.001, (), orders=orders)


@pytest.mark.parametrize(
    ("law", "stays"),
    [
        (of_orders("te.temperature_nonlinear", NAMED, (1.0,), 0.5), False),  # a part of what has no name
        (of_orders("te.temperature_nonlinear", NAMED, (1.0,), 2.0), True),  # larger than that
        (of_orders("te.temperature_nonlinear", NAMED, (1.0, 3.0), 0.5), True),  # of other orders as well
        (of_orders("te.resonance", NAMED, (1.0,), 0.5), True),  # no function of one quantity
        (of_orders("te.temperature_nonlinear", NAMED, (), 0.5), True),  # of the offset
    ],
)
def test_a_smaller_function_beside_something_without_a_name_on_the_same_order_is_a_part_of_it(
    law: Discovery, stays: bool
) -> None:
    told = of_orders(UNNAMED, UNKNOWN, (1.0,), 1.0)
    rows = SimpleNamespace(number=np.ones(10))
    outcome: Any = SimpleNamespace(discoveries=[law], rows=rows, usable=np.ones(10, dtype=bool), floor=1.0)
    transmission._put(told, True, outcome)
    assert any(d is law for d in outcome.discoveries) == stays
    whole = outcome.discoveries[-1]
    assert whole.effect == UNNAMED
    assert whole.added[0] == pytest.approx(1.0 if stays else 1.5)
