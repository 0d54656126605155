"""Where a value starts again, as a counter does that overflows, and whether the motion goes on evenly there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
_JUMP = 0.5
"""of the range, that a step is larger than which may be one where the value starts again"""
_MOST = 0.1
"""Share of the steps up to which jumps are told from motion: where there are more, a step may be half a turn."""
_BESIDE = 4
"""steps that are not 0, on each side of a jump, that it is compared with: a slow counter stays, and so does a log that
is faster than its drive"""
_WIDER = 0.5
"""of the largest step beside, by which one may be larger still: the speed changes"""
_MOSTLY = 0.5
"""Share of the jumps that go on evenly from which all are taken to: a row may be missing at one of them."""
_ROUND_DIGITS = 3
"""digits of a number of counts that somebody chose; more, and it is as the data have it"""


@dataclass(frozen=True, slots=True, eq=False)
class Jumps:
    """Steps (k,) over more than half of the range, after the samples ``rows``; ``low`` and ``high``: the least and the
    largest step beside each; ``span`` the range; ``whole`` where all values are whole numbers.
    """

    rows: NDArray[np.int64]
    steps: FloatArray
    low: FloatArray
    high: FloatArray
    span: float
    whole: bool

    def even(self, went: FloatArray) -> NDArray[np.bool_]:
        """Which of the steps (k,) that the jumps became are like those beside them."""
        spare = self.high - self.low + _WIDER * np.maximum(np.abs(self.low), np.abs(self.high)) + 2.0 * self.whole
        return np.asarray((went >= self.low - spare) & (went <= self.high + spare))

    def go_on(self, went: FloatArray) -> bool:
        """Whether the motion goes on evenly in most of the jumps."""
        return float(np.mean(self.even(went))) >= _MOSTLY

    def over(self, period: float) -> bool:
        """Whether it does where the value starts again after ``period``."""
        return self.go_on(self.steps - np.sign(self.steps) * period)

    def period(self) -> float | None:
        """After how much the value starts again, by the motion beside: a power of two or another round number that
        agrees, or else the largest value and one more; None where nothing makes the motion go on evenly.
        """
        sign = -np.sign(self.steps)
        ends = np.sort(np.stack([sign * (self.low - self.steps), sign * (self.high - self.steps)]), axis=0)
        spare = 0.5 * (ends[1] - ends[0]) + 1.0 * self.whole
        least = max(float(np.median(ends[0] - spare)), self.span + 1.0 * self.whole)
        most = float(np.median(ends[1] + spare))
        if least > most:
            return None
        # a counter that moves by single counts reaches each of its values
        slow = float(np.median(np.maximum(np.abs(self.low), np.abs(self.high)))) <= 1.0
        fits = None if slow else _roundest(least, most)
        found = (fits or float(math.ceil(least))) if self.whole else 0.5 * (least + most)
        return found if self.over(found) else None


def jumps_of(values: FloatArray) -> Jumps | None:
    """The jumps of values (N,); None where there are none, or so many that motion may be as fast."""
    steps = np.diff(values)
    numbers = values[np.isfinite(values)]
    span = float(np.ptp(numbers)) if numbers.size else 0.0
    large = np.abs(steps) > _JUMP * span
    rows = np.flatnonzero(large)
    if span == 0.0 or not rows.size or rows.size > _MOST * values.size:
        return None
    moves = np.flatnonzero(np.isfinite(steps) & (steps != 0.0) & ~large)
    if not moves.size:
        return None
    low, high = np.zeros(rows.size), np.zeros(rows.size)
    for k, place in enumerate(np.searchsorted(moves, rows)):
        beside = steps[moves[max(0, place - _BESIDE) : place + _BESIDE]]
        low[k], high[k] = beside.min(), beside.max()
    return Jumps(rows, steps[rows], low, high, span, bool(np.all(numbers == np.round(numbers))))


def _roundest(least: float, most: float) -> float | None:
    """The power of two between two numbers, or the whole number of the fewest digits; None where all have many."""
    power = 2.0 ** math.ceil(math.log2(least))
    if power <= most:
        return power
    for digits in range(1, _ROUND_DIGITS + 1):
        unit = max(1.0, 10.0 ** (math.floor(math.log10(least)) + 1 - digits))
        number = math.ceil(least / unit) * unit
        if number <= most:
            return number
    return None
