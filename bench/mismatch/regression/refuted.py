"""What recordings held out refute is not told."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.model import ChannelModel, Chosen, of_start


def not_refuted(model: ChannelModel, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without those with which recordings held out are predicted far worse than without them.

    Recordings held out never choose an effect, a form or a number. What they refute is not told; a note says so.
    """
    problem = model.problem
    held = problem.held_out
    if np.unique(problem.rows.frame.recording[held]).size < criteria.FEWEST_REFUTING:
        return list(chosen)
    part, number = problem.rows.frame, problem.rows.number[held]

    def left(own: Sequence[Chosen]) -> float:
        said = model.predict(part, own, model.refitted(own))
        if problem.spec.integral:
            said = of_start(problem, said)
        return float(np.sqrt(np.average((problem.rows.y - said)[held] ** 2, weights=number)))

    current = list(chosen)
    while current:
        whole = left(current)
        without = [left([o for o in current if o is not c]) for c in current]
        worst = int(np.argmin(without))
        if whole <= criteria.REFUTED * without[worst]:
            break
        gone = current.pop(worst)
        model.notes.append(
            f"{gone.main.regressor.words} gained in the recordings that were fitted, but recordings held out are"
            f" predicted {whole / without[worst]:.2g} times as badly with it: it is not told"
        )
    return current
