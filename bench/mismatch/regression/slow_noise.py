"""The noise floor of a channel that changes slowly: how its values scatter about a smooth course; no model needed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch.regression.noise import middle_variance
from bench.mismatch.regression.problem import ChannelProblem
from bench.simulation.frame import FloatArray, IntArray

WINDOW = 9
"""rows of two seconds through which a parabola is laid"""
NORMAL_QUARTILES = 1.349
"""distance of the quartiles of a normal distribution, in standard deviations"""
ROUNDING = 1e-12
"""variance about parabolas, over that of the channel, below which it is rounding of the arithmetic and no noise"""


def scattered(problem: ChannelProblem) -> tuple[float, float | None]:
    """Noise of a sample where the channel changes slowly, and its standard error.

    Its scatter inside the rows, and that of the rows about a parabola through each few of them: no balance of heat
    bends more within a quarter of a minute. Medians over the recordings.
    """
    rows = problem.rows
    recordings = _rows_of_recordings(problem)
    inside = _middles([rows.within[c] * rows.number[c] / (rows.number[c] - 1.0) for c in recordings])
    squares = inside + np.asarray([_about_parabolas(rows.y[c]) for c in recordings])
    spread = float(1.4826 * np.median(np.abs(squares - np.median(squares))) / np.sqrt(max(squares.size, 1)))
    floor = float(np.sqrt(np.median(squares)))
    return floor, (1.2533 * spread / (2.0 * floor) if floor > 0.0 and squares.size > 2 else None)


def _middles(variances: Sequence[FloatArray]) -> FloatArray:
    """Middle of each recording's estimates of a variance, as that of chi-squares whose degrees of freedom their scatter
    tells.

    A transmitter that reads a few times a second repeats its readings: a row of hundreds of samples holds two or three.
    The cube root of a chi-square of k degrees of freedom over k is normal, its mean 1 - x and its variance
    x = 2/(9 k) (Wilson and Hilferty, PNAS 17 (1931) 684).
    """
    roots = [np.cbrt(values) for values in variances]
    middles = np.asarray([np.median(root) for root in roots])
    relative = [root / middle for root, middle in zip(roots, middles, strict=True) if middle > 0.0]
    if not relative:
        return np.zeros(len(roots))
    low, high = np.quantile(np.concatenate(relative), [0.25, 0.75])
    spread = ((high - low) / NORMAL_QUARTILES) ** 2
    # x/(1 - x)**2 = spread
    x = 2.0 * spread / (2.0 * spread + 1.0 + np.sqrt(4.0 * spread + 1.0))
    return np.asarray((middles / (1.0 - x)) ** 3)


def of_a_row(problem: ChannelProblem) -> float | None:
    """Noise of a row where the channel changes slowly: the middle recording's scatter about parabolas; None where all
    are too short, or too coarse to scatter at all.
    """
    parts = [problem.rows.y[chosen] for chosen in _rows_of_recordings(problem)]
    rounding = ROUNDING * float(np.var(np.concatenate(parts))) if parts else 0.0
    told = [square for part in parts if (square := _about_parabolas(part)) > rounding]
    return float(np.sqrt(np.median(told))) if told else None


def _rows_of_recordings(problem: ChannelProblem) -> list[IntArray]:
    """Rows of each recording that are compared and hold more than a sample."""
    usable = np.flatnonzero(problem.usable & (problem.rows.number > 1.5))
    recordings = problem.rows.frame.recording[usable]
    return [usable[recordings == r] for r in np.unique(recordings)]


def _about_parabolas(y: FloatArray) -> float:
    """Variance of values (n,) about a parabola through each window of them; 0 where they are too few."""
    if y.size < WINDOW:
        return 0.0
    line = np.linspace(-1.0, 1.0, WINDOW)
    basis = np.linalg.qr(np.column_stack([np.ones(WINDOW), line, line**2]))[0]
    parts = np.lib.stride_tricks.sliding_window_view(y, WINDOW)[:: WINDOW // 2]
    left = parts - parts @ basis @ basis.T
    squares = np.sum(left**2, axis=1) / (WINDOW - 3)
    return middle_variance(squares, np.full(squares.size, WINDOW - 3.0))
