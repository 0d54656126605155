"""States that are not recorded: found where something is left, and not where nothing is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.hidden_states import with_states
from bench.mismatch.regression.problem import ChannelProblem
from bench.mismatch.regression.search import searched
from bench.mismatch.regression.state_scales import is_of_state
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import quantity, state_of
from tests.bench.mismatch.regression.synthetic import campaign, problem

NOISE = 0.01
FRAME = campaign(72, seed=3)
# recordings follow each other more quickly than the state does, at speeds in no order
ORDER = np.random.default_rng(5).permutation(72)[FRAME.recording]
SHUFFLED = replace(
    FRAME,
    time=200.0 * FRAME.recording + FRAME.elapsed,
    velocity=FRAME.direction * np.geomspace(0.003, 0.17, 72)[ORDER],
)


def asked(extra: FloatArray) -> ChannelProblem:
    frame = SHUFFLED
    y = 0.4 * frame.direction + 0.002 * frame.velocity * frame.ratio + extra
    own = problem(frame, y + NOISE * np.random.default_rng(2).normal(size=frame.size))
    folds = own.folds.copy()
    folds[::5] = -1
    return replace(own, folds=folds)


def test_grease_that_is_broken_by_motion_is_found_with_its_time() -> None:
    broken = quantity("recent_speed_500s", SHUFFLED)
    first = searched(asked(-2.0 * SHUFFLED.direction * broken), 0)
    again = with_states(first, 0)
    states = [c.main.regressor for c in again.model.chosen if is_of_state(c.main.regressor)]
    assert states
    found = state_of(states[0].variables[0])
    assert found is not None
    assert found[0] == "recent_speed"
    assert found[1] == pytest.approx(500.0, rel=0.25)
    again.close()


def test_where_nothing_is_left_the_search_stays_what_it_is() -> None:
    first = searched(asked(np.zeros(SHUFFLED.size)), 0)
    assert with_states(first, 0) is first
    first.close()


def test_scatter_of_each_recording_is_no_state() -> None:
    levels = 0.05 * np.random.default_rng(8).normal(size=72)[SHUFFLED.recording]
    found = with_states(searched(asked(levels), 0), 0)
    assert not any(is_of_state(c.main.regressor) for c in found.model.chosen)
    found.close()
