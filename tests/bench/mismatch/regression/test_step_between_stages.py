"""A step of a level between two stages of a campaign: where the temperature only rises nobody knows whether it came
with the time or with the temperature; where it falls again, it is one of them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.search import searched
from bench.mismatch.regression.slots import Slot, slots
from bench.mismatch.regression.succession import settle
from bench.simulation.frame import Frame
from bench.simulation.terms import LIBRARY, TRANSMISSION_ERROR
from tests.bench.mismatch.regression.test_one_way import FRAME, RECORDINGS, measured

STAGES = 6
DRIFT, WARMTH = "te.drift_time", "te.temperature_nonlinear"
PART = FRAME.recording * STAGES / RECORDINGS
STAGE = PART.astype(int)


def campaign_at(*celsius: float) -> Frame:
    """Recordings in stages at these temperatures, in each of which they rise by less than a kelvin."""
    return replace(FRAME, temperature=np.array(celsius)[STAGE] + 0.8 * (PART % 1.0))


UP = campaign_at(24.0, 28.0, 32.0, 36.0, 40.0, 44.0)
UP_AND_DOWN = campaign_at(24.0, 34.0, 44.0, 29.0, 39.0, 27.0)


def told(level: np.ndarray, frame: Frame) -> Slot:
    """The one effect of a level (n,)."""
    search = searched(measured(level, frame))
    settle(search)
    (slot,) = slots(search)
    return slot


def as_good(slot: Slot) -> set[str]:
    return {slot.chosen.effect, *(a.chosen.effect for a in slot.alternatives if a.as_good)}


@pytest.mark.parametrize(("frame", "effects"), [(UP, {DRIFT, WARMTH}), (UP_AND_DOWN, {DRIFT})], ids=["up", "down too"])
def test_a_step_over_time_is_one_over_temperature_as_well_where_that_only_rises(
    frame: Frame, effects: set[str]
) -> None:
    assert as_good(told((STAGE >= 3).astype(float), frame)) == effects


def test_a_step_at_a_temperature_in_a_campaign_that_cools_again_is_no_drift() -> None:
    slot = told((UP_AND_DOWN.temperature > 36.5).astype(float), UP_AND_DOWN)
    assert as_good(slot) == {WARMTH}
    # its place is anywhere in the gap, and it is sharp beside it
    middle, width = slot.chosen.main.regressor.point  # type: ignore[attr-defined]
    assert 34.8 + width < middle < 39.0 - width


def test_a_step_over_time_is_looked_for_in_the_gaps_between_recordings() -> None:
    form = LIBRARY[DRIFT].form(TRANSMISSION_ERROR, "loosening")
    assert form is not None
    moments = [moment for (moment,) in form.grid(UP)]
    first = np.flatnonzero(np.diff(UP.recording)) + 1
    assert len(moments) == first.size
    assert all(UP.time[k - 1] < moment < UP.time[k] for k, moment in zip(first, moments, strict=True))
    # of many gaps some; of a few recordings even moments as well
    many = replace(UP, recording=np.arange(UP.size), time=np.arange(UP.size, dtype=float))
    assert len(form.grid(many)) == 60
    few = replace(UP, recording=np.minimum(UP.recording, 2))
    assert len(form.grid(few)) == 22 + 2
