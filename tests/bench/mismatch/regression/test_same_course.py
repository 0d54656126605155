"""What only ever rises through a campaign may be of the temperature or of the time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.same_course import turns
from bench.mismatch.regression.search import searched
from bench.mismatch.regression.succession import settle
from tests.bench.mismatch.regression.test_one_way import FRAME, SHARE, measured


@pytest.mark.parametrize(
    ("temperature", "ambiguous"),
    [
        (22.0 + 9.0 * SHARE**1.5, True),
        (22.0 + 9.0 * np.sin(np.pi * SHARE), False),
    ],
)
def test_a_steep_function_of_a_temperature_that_only_rises_may_be_one_of_the_time(
    temperature: np.ndarray, ambiguous: bool
) -> None:
    frame = replace(FRAME, temperature=temperature)
    search = searched(measured(np.tanh((temperature - 27.0) / 1.0), frame))
    (slot,) = settle(search)
    names = {slot.chosen.effect, *(c.chosen.effect for c in slot.alternatives if c.as_good)}
    assert "te.temperature_nonlinear" in names
    assert ("te.drift_time" in names) is ambiguous


@pytest.mark.parametrize(
    ("course", "number"),
    [
        ([0.0, 0.1, 0.5, 1.0], 0),
        ([1.0, 0.9, 0.2, 0.0, 0.1], 0),
        ([0.0, 1.0, 0.5, 0.0], 1),
        ([0.0, 1.0, 0.95, 1.0], 0),
        ([0.0, 1.0, 0.0, 1.0, 0.0], 3),
        ([1.0, 0.0, 1.0], 1),
        ([2.0, 2.0], 0),
    ],
)
def test_a_course_turns_where_it_goes_back_by_more_than_a_form_is_off(course: list[float], number: int) -> None:
    assert turns(np.array(course)) == number


def test_lost_motion_is_no_function_of_anything_else() -> None:
    search = searched(measured(np.tanh(FRAME.torque / 15.0)))
    (slot,) = settle(search)
    assert slot.chosen.effect == "te.lost_motion"
    assert "te.drift_time" not in {c.chosen.effect for c in slot.alternatives if c.as_good}
