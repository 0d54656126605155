"""States that are not recorded: found where something is left, and not where nothing is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch.regression import hidden_states
from bench.mismatch.regression.candidates import free_candidates
from bench.mismatch.regression.hidden_states import predicts_better, with_states
from bench.mismatch.regression.model import Chosen
from bench.mismatch.regression.problem import ChannelProblem
from bench.mismatch.regression.regressors import kinds
from bench.mismatch.regression.search import begun, searched
from bench.mismatch.regression.state_scales import is_of_state, scaled
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import STATE_TIMES_S, quantity, state_named, state_of
from bench.simulation.terms import TRANSMISSION_ERROR
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
    # which scale noise likes better than one of those asked is noise's own affair
    both = ((block, scaled(model, block)) for block in blocks)
    refined = next(r for block, r in both if r.regressor.variables != block.regressor.variables)
    search.refuted.append(Chosen(refined))
    search.without_refuted()
    left = {b.regressor.times for b in search.blocks if kinds(b.regressor) == ("recent_speed",)}  # type: ignore[attr-defined]
    assert left == {("w",)}


@pytest.mark.parametrize(("begin", "true", "told"), [(2000.0, 3000.0, 2000.0), (125.0, 200.0, 200.0)])
def test_a_scale_is_refined_within_what_is_asked(begin: float, true: float, told: float) -> None:
    frame = SHUFFLED
    slow = quantity(state_named("recent_speed", true), frame)
    search = begun(replace(asked(2.0 * frame.direction * slow), states=True))
    one = next(b for b in search.blocks if b.regressor.variables == (state_named("recent_speed", begin),))
    found = state_of(scaled(search.model, one).regressor.variables[0])
    assert found is not None
    assert found[1] == pytest.approx(told, rel=0.15)


def test_motion_of_no_set_points_is_asked_for_no_state() -> None:
    own = replace(asked(-2.0 * SHUFFLED.direction * quantity("recent_speed_500s", SHUFFLED)), free=True)
    first = searched(own, 0)
    assert first.model.noise.independent_rows is not None
    assert with_states(first, 0) is first
    first.close()


def test_what_predicts_better_leaves_the_other_search_as_it_is() -> None:
    own = asked(-2.0 * SHUFFLED.direction * quantity("recent_speed_500s", SHUFFLED))
    first, again = searched(own, 0), searched(replace(own, states=True), 0)
    before, density, scans = first.model, first.density(first.model.chosen), list(first.scans)
    assert predicts_better(again, first, again.model.chosen, first.model.chosen)
    assert first.model is before
    assert first.scans == scans
    assert first.density(before.chosen) == pytest.approx(density, rel=1e-9)
    assert not predicts_better(first, again, first.model.chosen, again.model.chosen)
    # what would not be reported says nothing for a search
    assert not predicts_better(again, first, [], first.model.chosen)
    first.close()
    again.close()


@dataclass(frozen=True)
class Model:
    """Of a search: its effects and the price of one."""

    chosen: list[Chosen]
    price: float = 3.0


@pytest.mark.parametrize(
    ("gained", "better"),
    [
        ([1.0] * 8, True),
        ([1.0] * 5, False),  # of too few points
        ([0.3] * 8, False),  # less than the price
        ([30.0, -29.0, 30.0, -25.0, 20.0, -20.0, 5.0, -4.0], False),  # less than it scatters
    ],
)
def test_what_predicts_better_gains_its_price_and_more_than_it_scatters(
    gained: list[float], better: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    moved = SimpleNamespace(model=Model([]), density=lambda _: np.array(gained) - 10.0)
    monkeypatch.setattr(hidden_states, "carried_over", lambda *_: moved)
    other = SimpleNamespace(model=Model([]), scans=[], to_be_beaten=lambda _: np.full(len(gained), -10.0))
    assert predicts_better(cast("Any", SimpleNamespace(model=Model([]))), cast("Any", other), [], []) is better


def test_a_loss_that_nothing_tells_is_no_state() -> None:
    frame = replace(SHUFFLED, power=np.abs(SHUFFLED.torque * SHUFFLED.velocity))
    asked_of = [
        {kinds(f)[0] for f in free_candidates(TRANSMISSION_ERROR, one, states=True) if kinds(f)}
        for one in (frame, replace(frame, motor_torque=frame.torque / 185.0))
    ]
    assert asked_of[1] - asked_of[0] == {"recent_loss"}
