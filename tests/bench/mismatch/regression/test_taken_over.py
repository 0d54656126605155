"""A step at a temperature that was placed a little beside the true one, and what then seems to be missing beside it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.beside import shaped
from bench.mismatch.regression.regressors import Named, named
from bench.mismatch.regression.search import begun
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.taken_over import without_taken_over
from bench.simulation.frame import FloatArray
from bench.simulation.terms import TRANSMISSION_ERROR
from tests.bench.mismatch.regression.test_one_way import FRAME, RECORDINGS, measured

DRIFT, WARMTH = "te.drift_time", "te.temperature_nonlinear"
RISING = replace(FRAME, temperature=24.0 + 12.0 * FRAME.recording / RECORDINGS + 0.005 * FRAME.elapsed)
"""the bench warms up from recording to recording, and hardly inside one"""
MIDDLE, WIDTH = 30.0, 1.5
STEP = np.tanh((RISING.temperature - MIDDLE) / WIDTH)
LATER = 600.0 * 14
"""s after which a drift is set beside it"""


def search_of(level: FloatArray) -> Search:
    offsets = 0.02 * np.random.default_rng(7).normal(size=RECORDINGS)[RISING.recording]
    return begun(measured(level + offsets, RISING))


def warmth(middle: float, width: float) -> Named:
    return named(WARMTH, TRANSMISSION_ERROR, "transition", (middle, width))


def with_a_drift(level: FloatArray) -> Search:
    """A search whose model has the step beside its place, and a drift that takes what it leaves."""
    search = search_of(level)
    misplaced = shaped(search, [], warmth(MIDDLE + 1.5, WIDTH))
    assert misplaced is not None
    drift = shaped(search, [misplaced], named(DRIFT, TRANSMISSION_ERROR, "loosening", (LATER,)))
    assert drift is not None
    chosen = [misplaced, drift]
    return replace(search, model=replace(search.model, chosen=chosen, fit=search.model.refitted(chosen)))


def test_a_drift_beside_a_misplaced_step_goes() -> None:
    """It does where the step is refined with what the recordings say of each other. Without the step its changes
    between them look like offsets of theirs, which say nothing of its place.
    """
    search = with_a_drift(STEP)
    without_taken_over(search)
    assert [c.effect for c in search.model.chosen] == [WARMTH]
    term = search.model.chosen[0].main.regressor
    assert isinstance(term, Named)
    assert term.point == pytest.approx((MIDDLE, WIDTH), rel=0.05)


def test_a_drift_that_is_there_stays() -> None:
    search = with_a_drift(STEP + 0.4 * (RISING.time > LATER))
    without_taken_over(search)
    assert [c.effect for c in search.model.chosen] == [WARMTH, DRIFT]
