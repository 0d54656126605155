"""What points left out refute is not told."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.folds import carried, squares
from bench.mismatch.regression.heredity import without
from bench.mismatch.regression.model import Block, ChannelModel, Chosen, fit_blocks
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
        model.notes.append(
            f"{gone.main.regressor.words} gained in likelihood, but points left out of the fit are predicted"
            f" {np.sqrt(ratios[worst]):.3g} times as badly with it: it is not reported"
        )
    return current
