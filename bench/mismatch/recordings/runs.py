"""Which samples of a recording are smoothed together: a window of the rates reaches over no corner, and over lost
cycles in time, not in samples.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.recordings.smoothing import local_quadratic, window
from bench.simulation.frame import FloatArray, IntArray

LOST = 1.5
"""sample periods between two samples, above which cycles were lost"""
WIDEST_BRIDGE = 0.25
"""of a window of the rates: lost cycles that a straight line may stand in for. So wide it takes less than a tenth of an
acceleration; wider, it soon takes all of it.
"""


@dataclass(frozen=True, slots=True)
class Runs:
    """Samples (n,) at ``rate`` Hz.

    ``at``: place of each on the grid of the sample rate, lost cycles counted, no more of them than a window in one
    place; ``pieces``: steady segments, and what lost cycles leave whole (none: all samples are one); ``unknown``:
    samples whose rates cannot be told, for cycles lost nearby.
    """

    rate: float
    at: IntArray
    pieces: tuple[slice, ...]
    unknown: NDArray[np.bool_]

    @classmethod
    def whole(cls, size: int, rate: float) -> Runs:
        """All samples in one run, none lost."""
        return cls(rate, np.arange(size), (), np.zeros(size, dtype=bool))

    @classmethod
    def of(cls, time: FloatArray, rate: float, span: float, label: IntArray) -> Runs:
        """Runs of samples at times (n,) in s; ``span``: window of the rates in s; ``label``: number of the steady
        segment of each, -1 elsewhere.
        """
        width = window(rate, span)
        between = np.diff(time) * rate
        lost = between > LOST
        steps = np.where(lost, np.minimum(np.rint(between), width + 1), 1).astype(np.int64)
        at = np.concatenate(([0], np.cumsum(steps)))[: time.size]
        broken = np.flatnonzero((np.diff(label) != 0) | lost) + 1
        edges = [0, *broken.tolist(), time.size]
        pieces = tuple(slice(a, b) for a, b in itertools.pairwise(edges)) if len(edges) > 2 else ()
        unknown = np.zeros(time.size, dtype=bool)
        wide = np.concatenate(([False], lost & (steps - 1 > WIDEST_BRIDGE * width), [False]))
        for piece in pieces:
            if piece.stop - piece.start < width and (wide[piece.start] or wide[piece.stop]):
                unknown[piece] = True
        return cls(rate, at, pieces, unknown)

    def bridged(self, signal: FloatArray) -> FloatArray:
        """A signal (n,) on the grid, with straight lines over lost cycles."""
        if self.at.size == 0 or self.at[-1] + 1 == self.at.size:
            return signal
        return np.asarray(np.interp(np.arange(self.at[-1] + 1), self.at, signal))


def smoothed(signal: FloatArray, span: float, runs: Runs) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Value, first and second derivative in time (n,) by :func:`local_quadratic` over windows of ``span`` s; pieces no
    shorter than a window are smoothed by their own samples alone.
    """
    value, slope, curve = (x[runs.at] for x in local_quadratic(runs.bridged(signal), runs.rate, span))
    for piece in runs.pieces:
        if piece.stop - piece.start >= window(runs.rate, span):
            value[piece], slope[piece], curve[piece] = local_quadratic(signal[piece], runs.rate, span)
    return value, slope, curve
