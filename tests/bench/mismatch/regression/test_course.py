"""Regressors on many rows, a group of recordings at a time: the same as all rows at once."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.regression import course
from bench.mismatch.regression.excess import excess
from bench.mismatch.regression.regressors import named
from bench.simulation.terms import MOTOR_TORQUE, TRANSMISSION_ERROR
from tests.bench.mismatch.regression.synthetic import EACH, campaign

FRAME = campaign(10)
OFFSET = named("te.offset", TRANSMISSION_ERROR, "nominal")
DRY = named("friction.coulomb", MOTOR_TORQUE, "nominal")
CHOSEN = np.arange(7, FRAME.size, 41)


@pytest.mark.parametrize("rows", [1, 2 * EACH, 3 * EACH + 1, 1000 * EACH])
def test_groups_are_whole_recordings(monkeypatch: pytest.MonkeyPatch, rows: int) -> None:
    monkeypatch.setattr(course, "ROWS_AT_ONCE", rows)
    found = course.groups(FRAME)
    assert [r.start for r in found] == [0, *(r.stop for r in found[:-1])]
    assert found[-1].stop == FRAME.size
    assert all(r.start % EACH == 0 for r in found)
    assert max(r.stop - r.start for r in found) <= max(rows, EACH)


def test_what_is_added_is_that_of_all_rows_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(5)
    values, number = rng.normal(size=FRAME.size), rng.uniform(1.0, 9.0, FRAME.size)
    whole = OFFSET.columns(FRAME)
    coefficients = rng.normal(size=(whole.shape[1], 3))
    monkeypatch.setattr(course, "ROWS_AT_ONCE", 2 * EACH)
    assert course.added(OFFSET, FRAME, coefficients) == pytest.approx(whole @ coefficients)
    assert course.columns_at(OFFSET, FRAME, CHOSEN) == pytest.approx(whole[CHOSEN])
    left = course.beyond(values, [OFFSET, DRY], FRAME, number)
    assert left == pytest.approx(excess(values, [whole, DRY.columns(FRAME)], number), abs=1e-9)
