"""What points left out refute is not told."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.auxiliary import of_auxiliary
from bench.mismatch.regression.folds import carried, squares
from bench.mismatch.regression.heredity import without
from bench.mismatch.regression.model import Block, ChannelModel, Chosen, fit_blocks, of_start
from bench.mismatch.regression.regressors import UNKNOWN
from bench.simulation.frame import FloatArray


def not_refuted(model: ChannelModel, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without those with which points left out are predicted worse than without them, by more log-likelihood
    than noise gains in a search.

    The search asks for density: a form that is sure of most points may be wild at others, and say so. What a model is
    for is prediction. Only points that may be fitted are asked: recordings held out score, and choose nothing. And
    against an effect only points that others can stand for: without the one warm-up of a campaign nothing is known of
    what a warm-up shows.
    """
    current = list(chosen)
    while current:
        blocks = model.blocks(current)
        fitted = fit_blocks(model.bank, blocks, model.variances)

        def left(own: Sequence[Block], at: float = fitted.variance) -> FloatArray:
            return squares(model.bank, own, model.folds, at)

        whole = left(blocks)
        others = [without(current, c, model.problem.lacking) for c in current]
        beyond, ratios = [], []
        for c, own in zip(current, others, strict=True):
            squared = left(model.blocks(own))
            spared = carried(model.bank, blocks, c.main, model.folds, fitted) <= criteria.CANNOT_BE_SPARED
            asked = spared | (whole < squared)
            beyond.append(0.5 * float((whole - squared)[asked].sum()) - model.price)
            ratios.append(float(whole[asked].sum()) / max(float(squared[asked].sum()), 1e-300))
        worst = int(np.argmax(beyond))
        if not beyond[worst] > 0.0:
            break
        gone, current = current[worst], others[worst]
        note = (
            f"{gone.main.regressor.words} gained in likelihood, but points left out of the fit are predicted"
            f" {np.sqrt(ratios[worst]):.3g} times as badly with it: it is not reported"
        )
        if note not in model.notes:
            model.notes.append(note)
    return current


def borne_out(model: ChannelModel) -> list[Chosen]:
    """Effects of a model without the functions that have no name and with which recordings held out are predicted worse
    than without them.

    A function without a name claims nothing but that it predicts. Which one it is was chosen without these recordings;
    they only decide whether it is told. Names stay: they are told with half the confidence.
    """
    current = list(model.chosen)
    while True:
        asked = ((c, worse_with(model, current, c)) for c in current)
        refuted = next(((c, ratio) for c, ratio in asked if ratio is not None), None)
        if refuted is None:
            return current
        own, ratio = refuted
        model.notes.append(
            f"{own.main.regressor.words} gained in the fit, but recordings held out are predicted"
            f" {ratio:.3g} times as badly with it: it is not reported"
        )
        # what stood beside it may have made up for it: it is asked again
        current = without(current, own, model.problem.lacking)


def worse_with(model: ChannelModel, current: Sequence[Chosen], own: Chosen) -> float | None:
    """How many times as badly recordings held out are predicted with a function without a name beside the others of
    some effects; None where they are not against it.
    """
    problem = model.problem
    held = problem.held_out
    if own.effect != UNKNOWN or of_auxiliary(own.main.regressor) or not held.any():
        return None
    others = without(current, own, problem.lacking)
    left = [_left(model, chosen)[held] for chosen in (current, others)]
    number = problem.rows.number[held]
    change = left[0] ** 2 - left[1] ** 2
    worse = float(np.average(change, weights=number))
    ratio = np.sqrt(np.average(left[0] ** 2, weights=number) / max(np.average(left[1] ** 2, weights=number), 1e-300))
    # a function that is true takes its square off, one that is not adds it: what predicts worse is more likely not
    # true, however small the difference
    return float(ratio) if worse > 0.0 else None


def _left(model: ChannelModel, chosen: Sequence[Chosen]) -> FloatArray:
    """What some effects leave of each row (n,)."""
    said = model.predict(model.problem.rows.frame, chosen, model.refitted(chosen))
    return np.asarray(model.problem.rows.y - of_start(model.problem, said))
