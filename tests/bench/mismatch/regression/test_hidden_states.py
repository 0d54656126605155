"""States that are not recorded: found where something is left, and not where nothing is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.hidden_states import predicts_better, with_states
from bench.mismatch.regression.model import Chosen
from bench.mismatch.regression.problem import ChannelProblem
from bench.mismatch.regression.regressors import kinds
from bench.mismatch.regression.search import begun, searched
from bench.mismatch.regression.state_scales import is_of_state, scaled
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import STATE_TIMES_S, quantity, state_named, state_of
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


def test_a_state_that_was_refuted_is_none_at_another_scale() -> None:
    search = begun(replace(asked(np.zeros(SHUFFLED.size)), states=True))
    model = search.model
    blocks = [b for b in search.blocks if kinds(b.regressor) == ("recent_speed",)]
    assert len(blocks) > len(STATE_TIMES_S)
    refined = scaled(model, blocks[0])
    assert refined.regressor.variables != blocks[0].regressor.variables
    search.refuted.append(Chosen(refined))
    search.without_refuted()
    left = {b.regressor.times for b in search.blocks if kinds(b.regressor) == ("recent_speed",)}  # type: ignore[attr-defined]
    assert left == {("w",)}


@pytest.mark.parametrize(("begin", "true"), [(8.0, 5.0), (2000.0, 3000.0), (125.0, 200.0)])
def test_a_scale_is_refined_within_what_is_asked(begin: float, true: float) -> None:
    frame = SHUFFLED
    search = begun(
        replace(asked(2.0 * frame.direction * quantity(state_named("recent_speed", true), frame)), states=True)
    )
    one = next(b for b in search.blocks if b.regressor.variables == (state_named("recent_speed", begin),))
    found = state_of(scaled(search.model, one).regressor.variables[0])
    assert found is not None
    assert STATE_TIMES_S[0] <= found[1] <= STATE_TIMES_S[-1]


def test_motion_of_no_set_points_is_asked_for_no_state() -> None:
    own = replace(asked(-2.0 * SHUFFLED.direction * quantity("recent_speed_500s", SHUFFLED)), free=True)
    first = searched(own, 0)
    assert first.model.noise.independent_rows is not None
    assert with_states(first, 0) is first
    first.close()


def test_what_predicts_better_is_asked_with_the_same_noise_and_leaves_the_other_search_as_it_is() -> None:
    own = asked(-2.0 * SHUFFLED.direction * quantity("recent_speed_500s", SHUFFLED))
    first, again = searched(own, 0), searched(replace(own, states=True), 0)
    before = first.model
    assert predicts_better(again, first)
    assert first.model is before
    assert not predicts_better(first, again)
