"""Wander: what moves slowly inside recordings and follows nothing, such as a seal that sticks now and then.

Noise forgets itself within a second or two. Means over some seconds therefore differ as much from their neighbours as
from any other window of the same recording (von Neumann's ratio is one); where they differ less from their neighbours,
something slower than noise is at work.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.simulation.frame import FloatArray, Frame, recording_starts

WINDOW_S = 4.0
LEAST_WINDOWS = 5
LEAST_RATIO = 1.6
"""variance of the windows' means over half the mean square of their steps; coloured noise of a second reaches 1.2"""
LEAST_SHARE = 0.02
"""variance of the wander over that of the samples"""


@dataclass(frozen=True, slots=True)
class Wander:
    """Slow structure: its standard deviation with the error of that, von Neumann's ratio inverted, and the strongest
    recordings.
    """

    deviation: float
    error: float
    ratio: float
    recordings: tuple[int, ...]


def wander(residual: FloatArray, frame: Frame, used: NDArray[np.bool_], variance: float) -> Wander | None:
    """Look for slow structure in a residual on block rows; ``variance`` is that of single samples."""
    starts = recording_starts(frame)
    total: list[tuple[int, float, float, int]] = []
    for a, b in itertools.pairwise(starts):
        chosen = np.flatnonzero(used[a:b] & (frame.steady[a:b] > 0.5)) + a
        if chosen.size < 2 * LEAST_WINDOWS:
            continue
        window = np.floor((frame.elapsed[chosen] - frame.elapsed[chosen[0]]) / WINDOW_S).astype(np.int64)
        count = np.bincount(window)
        mean = np.bincount(window, residual[chosen]) / np.maximum(count, 1)
        mean = mean[count >= 0.7 * np.median(count)]
        if mean.size < LEAST_WINDOWS:
            continue
        total.append((int(frame.recording[a]), float(np.var(mean, ddof=1)), _steps(mean), mean.size - 1))
    if len(total) < LEAST_WINDOWS:
        return None
    weight = np.array([row[3] for row in total], dtype=np.float64)
    whole = float(np.average([row[1] for row in total], weights=weight))
    fast = float(np.average([row[2] for row in total], weights=weight))
    slow = whole - fast
    if whole < LEAST_RATIO * fast or slow < LEAST_SHARE * variance:
        return None
    strongest = sorted(total, key=lambda row: row[2] - row[1])[:5]
    deviation = float(np.sqrt(slow))
    error = deviation / float(np.sqrt(2.0 * weight.sum()))
    return Wander(deviation, error, whole / fast, tuple(row[0] for row in strongest))


def _steps(mean: FloatArray) -> float:
    return float(0.5 * np.mean(np.diff(mean) ** 2))
