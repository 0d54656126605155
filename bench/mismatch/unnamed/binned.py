"""A residual in means over a second, by pieces of recordings."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bench.mismatch.recordings.rows import settled_rows
from bench.mismatch.regression.model import explained
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray, Frame, IntArray

BIN_S = 1.0
"""means of the residual over this long; stays that are shorter are noise here"""
LONGEST = 120
"""bins of a piece; longer recordings are cut"""
FEWEST_BINS = 8
FEWEST_PIECES = 12
OUTLIER = 4.0
"""standard deviations from the neighbours beyond which one bin is left out"""
NEIGHBOURS = 5


@dataclass(frozen=True, slots=True)
class Pieces:
    """Means of a residual (pieces, bins), the samples of each relative to the usual bin (0: none, or an outlier), the
    same with the outliers, the recording of each piece; of each row used its piece and bin.
    """

    values: FloatArray
    weight: FloatArray
    with_outliers: FloatArray
    recording: IntArray
    rows: IntArray
    piece: IntArray
    bin: IntArray

    def some(self, chosen: NDArray[np.bool_]) -> Pieces:
        """Of some pieces, without their rows."""
        none = np.zeros(0, dtype=np.int64)
        weights = self.weight[chosen], self.with_outliers[chosen]
        return Pieces(self.values[chosen], *weights, self.recording[chosen], none, none, none)

    def every_bin(self) -> Pieces:
        """The same with the outliers: short stays are among them."""
        return replace(self, weight=self.with_outliers)


@dataclass(frozen=True, slots=True)
class Shown:
    """What a channel's model leaves of the training rows in steady motion: which of its ``rows`` (n,), their ``frame``,
    what is ``left`` (n,), ``number`` (n,) of samples.
    """

    rows: IntArray
    frame: Frame
    left: FloatArray
    number: FloatArray


def in_steady_motion(search: Search) -> Shown | None:
    """What a search's model leaves in steady motion; None of an integral, and where no speeds were set."""
    problem = search.model.problem
    if problem.spec.integral or problem.free:
        return None
    rows = np.flatnonzero(problem.train & settled_rows(problem.rows.frame))
    left = (problem.rows.y - explained(search.model))[rows]
    return Shown(rows, problem.rows.frame.take(rows), left, np.asarray(problem.rows.number[rows], dtype=np.float64))


def binned(frame: Frame, left: FloatArray, number: FloatArray) -> Pieces | None:
    """Bins of the rows of a frame, by recording and direction; None where too few are long enough.

    A recording's offset times the direction jumps at every reversal, and so does the error of a friction: a piece ends
    there, or what a whole recording is off by would be told as jumps.
    """
    bins = np.floor(frame.elapsed / BIN_S).astype(np.int64)
    turned = (np.diff(frame.recording) != 0) | (np.diff(frame.direction) != 0)
    keys = np.cumsum(np.append(False, turned)) * (1 << 32) + bins // LONGEST
    values: list[FloatArray] = []
    weights: list[FloatArray] = []
    recordings: list[int] = []
    used, piece, position = [], [], []
    for key in np.unique(keys):
        rows_of_key = np.flatnonzero(keys == key)
        at = bins[rows_of_key] - bins[rows_of_key].min()
        if at.max() + 1 < FEWEST_BINS:
            continue
        samples = np.asarray(np.bincount(at, number[rows_of_key], LONGEST), dtype=np.float64)
        sums = np.asarray(np.bincount(at, number[rows_of_key] * left[rows_of_key], LONGEST), dtype=np.float64)
        used.append(rows_of_key)
        piece.append(np.full(rows_of_key.size, len(values)))
        position.append(at)
        values.append(np.divide(sums, samples, out=np.zeros(LONGEST), where=samples > 0.0))
        weights.append(samples)
        recordings.append(int(frame.recording[rows_of_key[0]]))
    if len(values) < FEWEST_PIECES:
        return None
    used_bins = 1 + max(int(at.max()) for at in position)
    table: FloatArray = np.array(values)[:, :used_bins]
    weight: FloatArray = np.array(weights)[:, :used_bins]
    weight = weight / np.median(weight[weight > 0.0])
    weight[weight < 0.5] = 0.0  # begins and ends
    return Pieces(
        table,
        _without_outliers(table, weight),
        weight,
        np.array(recordings),
        np.concatenate(used),
        np.concatenate(piece),
        np.concatenate(position),
    )


def _without_outliers(values: FloatArray, weight: FloatArray) -> FloatArray:
    """Weights (pieces, bins) without single bins far from their neighbours: spikes are no level."""
    off = values - median_filter(values, (1, NEIGHBOURS), mode="nearest")
    seen = weight > 0.0
    spread = 1.4826 * float(np.median(np.abs(off[seen]))) or float(np.std(off[seen])) or 1.0
    return np.where(np.abs(off) > OUTLIER * spread, 0.0, weight)


def means(values: FloatArray, weight: FloatArray) -> FloatArray:
    """Weighted means (pieces,) of values (pieces, bins)."""
    return np.asarray((values * weight).sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-12))
