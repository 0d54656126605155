"""The noise floor of a channel that changes slowly: how its values scatter about a smooth course; no model needed."""

from __future__ import annotations

import numpy as np

from bench.mismatch.regression.noise import middle_variance, middles, of_each
from bench.mismatch.regression.problem import ChannelProblem
from bench.simulation.frame import FloatArray, IntArray

WINDOW = 9
"""rows of two seconds through which a parabola is laid"""
ROUNDING = 1e-12
"""variance about parabolas, over that of the channel, below which it is rounding of the arithmetic and no noise"""


def scattered(problem: ChannelProblem) -> tuple[float, float | None]:
    """Noise of a sample where the channel changes slowly, and its standard error.

    Its scatter inside the rows, and that of the rows about a parabola through each few of them: no balance of heat
    bends more within a quarter of a minute. Medians over the recordings.
    """
    rows = problem.rows
    recordings = _rows_of_recordings(problem)
    inside = middles([of_each(rows, c) for c in recordings])
    squares = inside + np.asarray([_about_parabolas(rows.y[c]) for c in recordings])
    spread = float(1.4826 * np.median(np.abs(squares - np.median(squares))) / np.sqrt(max(squares.size, 1)))
    floor = float(np.sqrt(np.median(squares)))
    return floor, (1.2533 * spread / (2.0 * floor) if floor > 0.0 and squares.size > 2 else None)


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
