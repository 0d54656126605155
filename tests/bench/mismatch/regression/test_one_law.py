"""Springs and a Stribeck curve, or springs that stretch to that curve: whichever predicts better, from either side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.beside import shaped
from bench.mismatch.regression.model import Chosen
from bench.mismatch.regression.one_law import one_or_two
from bench.mismatch.regression.regressors import Named
from bench.mismatch.regression.search import begun
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray, Frame, concatenate
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import campaign, problem

SPRINGS, STRIBECK = "friction.presliding", "friction.stribeck"


def _reversing() -> Frame:
    """Recordings that start, speed up and turn, each at speeds of its own."""
    one = campaign()
    rows = 240
    parts = []
    for number in range(16):
        elapsed = 0.05 * np.arange(rows)
        fastest = 3.0 + 2.5 * number
        omega = fastest * np.sin(2.0 * np.pi * elapsed / (0.05 * rows)) * (1.0 if number % 2 else -1.0)
        phi = np.cumsum(omega) * 0.05
        turned = np.flatnonzero(np.diff(np.sign(omega), prepend=0.0) != 0.0)[-1]
        since = np.abs(phi - np.where(np.arange(rows) < turned, 0.0, phi[turned])) / one.ratio
        part = one.take(np.zeros(rows, dtype=np.int64))
        parts.append(
            replace(
                part,
                recording=np.full(rows, number, dtype=np.int64),
                velocity=omega / one.ratio,
                direction=np.sign(omega).astype(np.int64),
                theta=phi / one.ratio,
                q=phi / one.ratio,
                travel=np.cumsum(np.abs(omega)) * 0.05 / one.ratio,
                reversal_travel=since,
                reversed_before=(np.arange(rows) >= turned).astype(np.float64),
                elapsed=elapsed,
                time=600.0 * number + elapsed,
                step=np.full(rows, 0.05),
            )
        )
    return concatenate(parts)


def _column(frame: Frame, effect: str, form: str, point: tuple[float, ...]) -> FloatArray:
    found = LIBRARY[effect].form(MOTOR_TORQUE, form)
    assert found is not None
    return found.columns(frame, point)[:, 0]


def _chosen(search: Search, others: list[Chosen], effect: str, form: str, point: tuple[float, ...]) -> Chosen:
    found = LIBRARY[effect].form(MOTOR_TORQUE, form)
    assert found is not None
    chosen = shaped(search, others, Named(LIBRARY[effect], MOTOR_TORQUE, found, point))
    assert chosen is not None
    return chosen


@pytest.mark.parametrize("begin", ["law", "names"])
@pytest.mark.parametrize("nature", ["law", "names"])
def test_the_one_that_nature_has_takes_the_place_of_the_other(nature: str, begin: str) -> None:
    frame = _reversing()
    friction = 0.5 * frame.direction + 0.006 * frame.omega
    if nature == "law":
        friction = friction + 0.3 * _column(frame, SPRINGS, "lugre", (2.0, 0.6, 8.0))
    else:
        friction = friction + 0.3 * _column(frame, SPRINGS, "dahl", (2.0,))
        friction = friction + 0.2 * _column(frame, STRIBECK, "gaussian", (8.0,))
    friction = friction + np.random.default_rng(4).normal(0.0, 0.01, frame.size)
    search = begun(problem(frame, np.asarray(friction)))
    if begin == "law":
        chosen = [_chosen(search, [], SPRINGS, "lugre", (2.0, 0.6, 8.0))]
    else:
        chosen = [_chosen(search, [], SPRINGS, "dahl", (2.0,))]
        chosen.append(_chosen(search, chosen, STRIBECK, "gaussian", (8.0,)))
    search.model = replace(search.model, chosen=chosen, fit=search.model.refitted(chosen))
    one_or_two(search)
    found = {c.effect: c.main.regressor for c in search.model.chosen}
    springs = found[SPRINGS]
    assert isinstance(springs, Named)
    assert set(found) == ({SPRINGS} if nature == "law" else {SPRINGS, STRIBECK})
    assert springs.form.name.startswith("lugre") is (nature == "law")


@pytest.mark.parametrize(("effect", "form", "point"), [(STRIBECK, "gaussian", (8.0,)), (SPRINGS, "dahl", (2.0,))])
def test_a_law_of_which_one_part_gains_nothing_is_the_other(effect: str, form: str, point: tuple[float, ...]) -> None:
    """A Stribeck curve alone is drawn by very stiff springs that stretch to it."""
    frame = _reversing()
    friction = 0.5 * frame.direction + 0.006 * frame.omega + 0.2 * _column(frame, effect, form, point)
    friction = friction + np.random.default_rng(4).normal(0.0, 0.01, frame.size)
    search = begun(problem(frame, np.asarray(friction)))
    search.model = replace(search.model, price=6.0)
    chosen = [_chosen(search, [], SPRINGS, "lugre", (0.06, 0.6, 8.0) if effect == STRIBECK else (2.0, 0.3, 8.0))]
    search.model = replace(search.model, chosen=chosen, fit=search.model.refitted(chosen))
    one_or_two(search)
    assert [c.effect for c in search.model.chosen] == [effect]
    assert not search.model.chosen[0].main.regressor.form.says


def test_springs_alone_are_left_alone() -> None:
    frame = _reversing()
    friction = 0.5 * frame.direction + 0.006 * frame.omega + 0.3 * _column(frame, SPRINGS, "dahl", (2.0,))
    search = begun(problem(frame, np.asarray(friction + np.random.default_rng(4).normal(0.0, 0.01, frame.size))))
    chosen = [_chosen(search, [], SPRINGS, "dahl", (2.0,))]
    search.model = replace(search.model, chosen=chosen, fit=search.model.refitted(chosen))
    one_or_two(search)
    assert search.model.chosen == chosen
