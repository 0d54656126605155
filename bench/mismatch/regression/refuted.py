"""What recordings held out refute is not told."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.model import ChannelModel, Chosen, of_start
from bench.simulation.frame import FloatArray


def not_refuted(model: ChannelModel, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without those with which recordings held out are predicted worse than without them, far worse in all or
    beyond chance when each recording is compared with itself.

    Recordings held out never choose an effect, a form or a number. What they refute is not told; a note says so.
    """
    problem = model.problem
    held = problem.held_out
    part, number = problem.rows.frame, problem.rows.number[held]
    recording = np.unique(part.recording[held], return_inverse=True)[1]
    recordings = int(recording.max(initial=-1)) + 1
    if recordings < criteria.FEWEST_REFUTING:
        return list(chosen)

    def left(own: Sequence[Chosen]) -> FloatArray:
        """Sum of squares of each recording held out."""
        said = model.predict(part, own, model.refitted(own))
        if problem.spec.integral:
            said = of_start(problem, said)
        return np.asarray(np.bincount(recording, number * (problem.rows.y - said)[held] ** 2))

    current = list(chosen)
    while current:
        whole = left(current)
        without = [left([o for o in current if o is not c]) for c in current]
        worst = int(np.argmin([w.sum() for w in without]))
        times = float(np.sqrt(whole.sum() / max(float(without[worst].sum()), 1e-300)))
        if times <= criteria.REFUTED and _by_chance(whole - without[worst]):
            break
        gone = current.pop(worst)
        model.notes.append(
            f"{gone.main.regressor.words} gained in the recordings that were fitted, but recordings held out are"
            f" predicted {times:.3g} times as badly with it: it is not told"
        )
    return current


def _by_chance(worse: FloatArray) -> bool:
    """Whether the mean of what each recording loses (n,) may be nothing or a gain."""
    if worse.size < criteria.FEWEST_COMPARED:
        return True
    error = float(np.std(worse, ddof=1)) / np.sqrt(worse.size)
    return float(worse.mean()) <= criteria.FLOOR_ERRORS * error
