"""What points left out refute is not told."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch.regression.folds import squares
from bench.mismatch.regression.model import ChannelModel, Chosen, fit_blocks
from bench.simulation.frame import FloatArray


def not_refuted(model: ChannelModel, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without those with which points left out are predicted worse than without them.

    The search asks for density: a form that is sure of most points may be wild at others, and say so. What a model is
    for is prediction. Only points that may be fitted are asked: recordings held out score, and choose nothing.
    """
    current = list(chosen)
    while current:
        variance = fit_blocks(model.bank, model.blocks(current), model.variances).variance

        def left(own: Sequence[Chosen], at: float = variance) -> FloatArray:
            return squares(model.bank, model.blocks(own), model.folds, at)

        whole = float(left(current).sum())
        without = [float(left([o for o in current if o is not c]).sum()) for c in current]
        worst = int(np.argmin(without))
        if whole <= without[worst]:
            break
        gone = current.pop(worst)
        model.notes.append(
            f"{gone.main.regressor.words} gained in likelihood, but points left out of the fit are predicted"
            f" {np.sqrt(whole / max(without[worst], 1e-300)):.3g} times as badly with it: it is not reported"
        )
    return current
