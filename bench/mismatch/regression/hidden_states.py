"""States that are not recorded: grease that recovers at rest, a winding that heats, a hose that is taken along.

What they do is a function of what was driven before, not of what is recorded now. So where a channel keeps something
without a name, or more than noise, it is searched again with functions of such states among the candidates
(:data:`bench.simulation.quantities.STATES`). They stay out of the first search: what is as slow as a state may look
like temperature, time or distance run.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.independent import much_is_left
from bench.mismatch.regression.model import ChannelModel, left_by
from bench.mismatch.regression.refuted import borne_out
from bench.mismatch.regression.search import carried_over, searched
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.state_scales import is_of_state


def with_states(search: Search, seed: int) -> Search:
    """A search of a channel, or another with states among the candidates, if the first ends with a function without a
    name or leaves more than noise, and the other finds a state that recordings held out bear out and predicts points
    left out better (:func:`predicts_better`). In motion of no set operating points no state is asked for.
    """
    model = search.model
    if model.noise.independent_rows is not None or not _something_is_left(model):
        return search
    again = searched(replace(model.problem, states=True), seed)
    # what stays out of its notes here is asked again, and noted, when alternatives are
    borne = borne_out(replace(again.model, notes=[]))
    if any(is_of_state(c.main.regressor) for c in borne) and predicts_better(again, search):
        search.close()
        return again
    again.close()
    return search


def _something_is_left(model: ChannelModel) -> bool:
    """Whether a model has a function without a name, or leaves more of the fitted rows than noise: as they are
    weighted, or by what is known of the noise of a sample. What an integral leaves grows by itself.
    """
    if model.nameless or much_is_left(model):
        return True
    problem = model.problem
    if problem.spec.integral or model.floor <= 0.0:
        return False
    left = float(np.average(left_by(model) ** 2, weights=problem.rows.number[problem.train]))
    return left > (criteria.MORE_THAN_NOISE**2 - 1.0) * model.floor**2


def predicts_better(one: Search, other: Search) -> bool:
    """Whether a search's effects predict points left out better than those of another search of the same rows do, with
    the noise of the other, by more log density than the standard error from one point to another.
    """
    before, scans = other.model, other.scans
    gained = -other.density(before.chosen)
    moved = carried_over(one, other)
    gained += moved.density(moved.model.chosen)
    other.model, other.scans = before, scans
    error = float(np.std(gained, ddof=1)) * float(np.sqrt(gained.size)) if gained.size > 1 else np.inf
    return float(gained.sum()) > criteria.ONE_ERROR * error
