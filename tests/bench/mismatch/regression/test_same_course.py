"""What only ever rises through a campaign may be of the temperature or of the time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.same_course import _Course, turns
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


def test_values_that_many_rows_share_are_one_of_a_course() -> None:
    """Loads that are kept, temperatures that are read to a tenth of a kelvin."""
    rng = np.random.default_rng(1)
    over = np.round(rng.uniform(20.0, 40.0, 20_000), 1)
    course = _Course.of(over, np.tanh((over - 30.0) / 2.0), np.ones(over.size))
    assert course is not None
    assert course.at.size == np.unique(over).size
    assert course.interpolated == pytest.approx(np.tanh((over - 30.0) / 2.0), abs=1e-9)
    # rows that it does not act on say nothing
    weight = (over > 25.0).astype(float)
    assert _Course.of(over, np.where(over > 25.0, over, 1e9), weight) is not None
    assert _Course.of(over, over, np.zeros(over.size)) is None
    assert _Course.of(np.repeat(over[:8], 100), np.zeros(800), np.ones(800)) is None


def test_lost_motion_at_noisy_speeds_and_temperatures_is_no_function_of_these() -> None:
    rng = np.random.default_rng(7)
    noisy = replace(
        FRAME,
        velocity=FRAME.velocity + 1e-5 * rng.normal(size=FRAME.size),
        temperature=FRAME.temperature + 0.01 * rng.normal(size=FRAME.size),
    )
    few = noisy.take(noisy.recording < 24)
    search = searched(measured(np.tanh(few.torque / 15.0), few))
    (slot,) = settle(search)
    assert slot.chosen.effect == "te.lost_motion"
    names = {c.chosen.effect for c in slot.alternatives if c.as_good}
    assert names.isdisjoint({"te.drift_time", "te.velocity_nonlinear", "te.temperature_nonlinear"})
