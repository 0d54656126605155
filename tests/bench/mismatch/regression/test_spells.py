"""What is there from a moment of the campaign on, or for a part of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.model import Chosen, add_block
from bench.mismatch.regression.one_way import named_by_course
from bench.mismatch.regression.search import begun
from bench.mismatch.regression.spells import spell, spell_ends, spell_of, spells
from bench.simulation.terms import TRANSMISSION_ERROR
from tests.bench.mismatch.regression.test_one_way import FRAME, SHARE, measured

HALF = FRAME.recording < 24


def test_what_is_there_in_the_last_recording_goes_on() -> None:
    ends = spell_ends(FRAME.take(HALF))
    stays, ended = (spell(TRANSMISSION_ERROR, "1", ends[9], end) for end in (ends[-1], ends[20]))
    assert stays.columns(FRAME)[~HALF].all()
    assert not ended.columns(FRAME)[~HALF].any()
    assert stays.words.endswith(" s on")
    assert ended.words.endswith(" s of the campaign")


@pytest.mark.parametrize(("last", "effect"), [(-1, "te.drift_time"), (30, "unknown")])
def test_a_step_that_stays_is_a_drift_and_a_level_that_comes_and_goes_is_none(last: int, effect: str) -> None:
    ends = spell_ends(FRAME)
    own = measured(((FRAME.time > ends[20]) & (FRAME.time <= ends[last])).astype(np.float64))
    model = begun(own).model
    step = Chosen(add_block(own, model.bank, spell(TRANSMISSION_ERROR, "1", ends[20], ends[last])))
    model = replace(model, chosen=[step], fit=model.refitted([step]))
    assert SHARE[FRAME.time > ends[20]].min() > 0.3
    assert named_by_course(model, [], step, model.fit).effect == effect


@pytest.mark.parametrize(("times", "fewest"), [("1", 1), ("tau", 2)])
def test_what_one_recording_lacks_is_no_spell_of_a_gain(times: str, fewest: int) -> None:
    """The first recording of a campaign often differs: a gain in all others is a gain."""
    frame = FRAME.take(FRAME.recording < 12)
    without = [
        int(np.unique(frame.recording[~found.columns(frame).any(axis=1)]).size)
        for one in spells(TRANSMISSION_ERROR, frame, times)
        if (found := spell_of(one)) is not None
    ]
    assert min(without) == fewest
