"""States that are not recorded: grease that recovers at rest, a winding that heats, a hose that is taken along.

What they do is a function of what was driven before, not of what is recorded now. So where a channel keeps something
without a name, or more than noise, it is searched again with functions of such states among the candidates
(:data:`bench.simulation.quantities.STATES`). They stay out of the first search: what is as slow as a state may look
like temperature, time or distance run.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.candidates import overlapping
from bench.mismatch.regression.independent import beyond_floor, much_is_left
from bench.mismatch.regression.model import ChannelModel, Chosen, left_by
from bench.mismatch.regression.refuted import borne_out
from bench.mismatch.regression.search import carried_over, searched
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.state_scales import is_of_state

FEWEST_POINTS = 6
"""points left out, below which their scatter tells no standard error"""


def with_states(search: Search, seed: int) -> Search:
    """A search of a channel, or another with states among the candidates, if the first ends with a function without a
    name or leaves more than noise, and the other finds a state that recordings held out bear out and predicts points
    left out better (:func:`predicts_better`). In motion of no set operating points no state is asked for, nor where
    recordings overlap in time.
    """
    model = search.model
    frame = model.problem.rows.frame.take(model.problem.train)
    if model.problem.states or model.noise.independent_rows is not None or overlapping(frame):
        return search
    if not _something_is_left(model):
        return search
    again = searched(replace(model.problem, states=True), seed)
    told = _reported(again) if _has_state(again.model.chosen) else []
    if _has_state(told) and predicts_better(again, search, told, _reported(search)):
        search.close()
        return again
    again.close()
    return search


def _has_state(chosen: Sequence[Chosen]) -> bool:
    return any(is_of_state(c.main.regressor) for c in chosen)


def _reported(search: Search) -> list[Chosen]:
    """Effects of a search that recordings held out bear out; its notes stay as they are."""
    return borne_out(replace(search.model, notes=[]))


def _something_is_left(model: ChannelModel) -> bool:
    """Whether a model has a function without a name, or leaves more of the fitted rows than noise: as they are
    weighted, recordings' offsets with them, or by what is known of the noise of a sample.
    """
    number = model.problem.rows.number[model.problem.train]
    return bool(model.nameless) or much_is_left(model) or beyond_floor(model, left_by(model), number)


def predicts_better(one: Search, other: Search, chosen: Sequence[Chosen], beside: Sequence[Chosen]) -> bool:
    """Whether effects ``chosen`` in one search predict points left out better than those ``beside`` of another search
    of the same rows do, with the noise of the other: by more log density than the price of an effect, and than the
    standard error from one point to another. Few points tell neither.
    """
    before, scans = other.model, other.scans
    gained = -other.to_be_beaten(beside)
    carried = copy(one)
    carried.model = replace(one.model, chosen=list(chosen))
    moved = carried_over(carried, other)
    gained += moved.density(moved.model.chosen)
    other.model, other.scans = before, scans
    if gained.size < FEWEST_POINTS:
        return False
    error = float(np.std(gained, ddof=1)) * float(np.sqrt(gained.size))
    return float(gained.sum()) > max(criteria.ONE_ERROR * error, before.price)
