"""Steps: what is left jumps up and down between two seconds, by more than it drifts elsewhere.

A chain of two levels (:mod:`bench.mismatch.unnamed.telegraph`) needs the levels themselves. Where slow waves are left
beside them, or were fitted to them, only the jumps are seen. The mean of the next seconds less that of the last ones is
Gaussian where the noise is, whatever its spectrum; a few that are many times as large as the others are no such noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from bench.mismatch.regression.maxima import tail_probability
from bench.mismatch.regression.state import Search
from bench.mismatch.unnamed.binned import BIN_S, binned, in_steady_motion, means
from bench.simulation.frame import FloatArray, IntArray

SIDES = 2
"""bins before and after a step whose means are compared: a stay that is shorter is a spike"""
FEWEST_STEPS = 2 * (2 * SIDES - 1) + 1
"""steps of a piece of which one jump, which shows in three of them, is less than half"""
SURROGATES = 200
MOST_ALIKE = 0.99
"""correlation from bin to bin of noise that is drawn"""
FEWEST_EACH_WAY = 2
"""steps up, and steps down: of one alone nobody can say that it comes and goes"""


@dataclass(frozen=True, slots=True)
class Steps:
    """Steps of a residual: their median ``height``, their ``number``, the mean time from one to the next (s), the
    p-value of the largest; ``course`` (n,): what they add to each row, about the mean of its piece.

    How uncertain the height is is not known: what was fitted has absorbed a part of each step.
    """

    height: float
    number: int
    every: float
    p_value: float
    course: FloatArray


def steps(search: Search, seed: int = 0) -> Steps | None:
    """Steps up and down in what a channel's model leaves in steady motion; None where too few stand out."""
    shown = in_steady_motion(search)
    pieces = None if shown is None else binned(shown.frame, shown.left, shown.number)
    if shown is None or pieces is None:
        return None
    seen = pieces.weight > 0.0
    step = _steps(pieces.values, seen)
    size = np.abs(step) / _usual(step)[:, None]
    chance = _largest_in_noise(pieces.values, seen, seed)
    least = float(np.max(chance))
    at = _summits(np.where(np.isfinite(size), size, 0.0), least)
    heights = step[at]
    if min(int(np.sum(heights > 0.0)), int(np.sum(heights < 0.0))) < FEWEST_EACH_WAY:
        return None
    course = np.zeros(search.model.problem.rows.size)
    course[shown.rows[pieces.rows]] = _course(heights, at, seen)[pieces.piece, pieces.bin]
    return Steps(
        float(np.median(np.abs(heights))),
        heights.size,
        BIN_S * float(seen.sum()) / heights.size,
        tail_probability(chance, float(np.nanmax(size))),
        course,
    )


def _steps(values: FloatArray, seen: NDArray[np.bool_]) -> FloatArray:
    """Mean of the next bins less that of the last ones at each bin (pieces, bins), about the piece's median where that
    is no step's: a drift is none. nan where one of them is missing.
    """
    shown = np.where(seen, values, np.nan)
    step = np.full(values.shape, np.nan)
    last = values.shape[1] - SIDES + 1
    before = sum(shown[:, SIDES - 1 - k : last - 1 - k] for k in range(SIDES))
    after = sum(shown[:, SIDES + k : last + k] for k in range(SIDES))
    step[:, SIDES:last] = (after - before) / SIDES
    long = np.isfinite(step).sum(axis=1) >= FEWEST_STEPS
    return step - np.where(long, _medians(step), 0.0)[:, None]


def _usual(step: FloatArray) -> FloatArray:
    """Usual size of a step in each piece (pieces,), by the median; no less than in the median piece, for few steps tell
    it badly.
    """
    each = 1.4826 * _medians(np.abs(step - _medians(step)[:, None]))
    return np.asarray(np.fmax(each, np.nanmedian(each)))


def _medians(values: FloatArray) -> FloatArray:
    """Median of each row without its nan; nan where it has nothing else. ``nanmedian`` takes thirty times as long."""
    ordered, number = np.sort(values, axis=1), np.isfinite(values).sum(axis=1)
    row = np.arange(values.shape[0])
    # nan are sorted behind all others
    return np.asarray(0.5 * (ordered[row, np.maximum(number - 1, 0) // 2] + ordered[row, number // 2]))


def _largest_in_noise(values: FloatArray, seen: NDArray[np.bool_], seed: int) -> FloatArray:
    """Largest step over the usual one in Gaussian noise as long, and as alike from bin to bin (SURROGATES,)."""
    rng = np.random.default_rng([seed, 5])
    centre = np.where(seen, values - means(values, seen.astype(np.float64))[:, None], 0.0)
    both = seen[:, 1:] & seen[:, :-1]
    product, square = centre[:, 1:] * centre[:, :-1], centre[:, 1:] ** 2
    alike = float(np.clip(product[both].sum() / max(square[both].sum(), 1e-300), 0.0, MOST_ALIKE))
    out = np.empty(SURROGATES)
    for k in range(SURROGATES):
        noise = rng.normal(size=values.shape)
        noise[:, 1:] *= np.sqrt(1.0 - alike**2)
        step = _steps(np.asarray(lfilter([1.0], [1.0, -alike], noise, axis=1)), seen)
        out[k] = np.nanmax(np.abs(step) / _usual(step)[:, None])
    return out


def _summits(size: FloatArray, least: float) -> tuple[IntArray, IntArray]:
    """Pieces and bins at which steps are larger than the ``least``, the largest of those that overlap."""
    width = 2 * SIDES - 1
    padded = np.pad(size, ((0, 0), (width // 2, width // 2)))
    around = np.lib.stride_tricks.sliding_window_view(padded, width, axis=1).max(axis=-1)
    piece, bin_ = np.nonzero((size > least) & (size == around))
    return piece, bin_


def _course(heights: FloatArray, at: tuple[IntArray, IntArray], seen: NDArray[np.bool_]) -> FloatArray:
    """What steps of some ``heights`` add to each bin (pieces, bins), about the mean of the bins of the piece."""
    course = np.zeros(seen.shape)
    np.add.at(course, at, heights)
    course = np.cumsum(course, axis=1)
    return np.asarray(np.where(seen, course - means(course, seen.astype(np.float64))[:, None], 0.0))
