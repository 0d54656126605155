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
from bench.mismatch.regression.model import ChannelModel
from bench.mismatch.regression.refuted import more_than_noise, remaining
from bench.mismatch.regression.search import searched
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.state_scales import is_of_state


def with_states(search: Search, seed: int) -> Search:
    """A search of a channel, or another with states among the candidates, if the first ends with a function without a
    name or leaves more than noise, the other finds a state, and it predicts recordings held out better
    (:func:`predicts_better`).
    """
    problem = search.model.problem
    if not problem.held_out.any() or not _something_is_left(search.model):
        return search
    again = searched(replace(problem, states=True), seed)
    found = any(is_of_state(c.main.regressor) for c in again.model.chosen)
    if found and predicts_better(again.model, search.model):
        search.close()
        return again
    again.close()
    return search


def _something_is_left(model: ChannelModel) -> bool:
    """Whether a model has a function without a name, or leaves more than noise: of the fitted rows as they are
    weighted, or of those held out beside what is known of the noise of a sample.
    """
    return bool(model.nameless) or much_is_left(model) or more_than_noise(model, model.chosen)


def predicts_better(one: ChannelModel, other: ChannelModel) -> bool:
    """Whether a model leaves less of recordings held out than another of the same problem does: over all of them, and
    in the mean over the recordings of the logarithm of what is left, by more than its standard error. Where much is
    left, a few recordings have most of it, and differ by as much.
    """
    problem = one.problem
    held = problem.held_out
    number, recording = problem.rows.number[held], problem.rows.frame.recording[held]
    left = [np.bincount(recording, number * remaining(m, m.chosen)[held] ** 2) for m in (one, other)]
    seen = np.bincount(recording, number) > 0
    ratio = np.log(left[1][seen] / np.maximum(left[0][seen], 1e-300))
    if ratio.size < 2 or left[0].sum() >= left[1].sum():
        return False
    return bool(ratio.mean() > criteria.ONE_ERROR * float(ratio.std(ddof=1)) / np.sqrt(ratio.size))
