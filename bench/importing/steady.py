"""Where a machine turned at one speed: stretches of a recording whose mapping names no segments.

What comes once a revolution, tones and noise are read from steady motion. A logger's file does not say where that is,
the angle does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
PARTS = 8
"""parts of a revolution of the output whose speeds are compared"""
WITHIN = 0.08
"""by which the speed of each part may differ from the middle of all, over that: the wavering that the analysis takes
for one speed"""
LEAST_S = 1.0
"""A shaft at full speed turns several times while it only passes through the top of a swing: steady is what lasts, many
times as long as rates are smoothed over."""
_STRAIGHT = 0.95
"""of the way run through in a part, that its ends lie apart: less, and the motion turned back within"""


def steady_stretches(turned: FloatArray, run: FloatArray, time: FloatArray) -> list[slice]:
    """Rows of the stretches of a revolution and a second or more at one speed.

    Parameters
    ----------
    turned : (N,) angle of the output in revolutions.
    run : (N,) revolutions run through, never falling, from 0.
    time : (N,) s.

    The parts at the ends of a stretch are left out, where a ramp may begin or end; not at the ends of the rows.
    """
    count = int(run[-1] * PARTS + 1e-6) if run.size else 0
    if count < PARTS:
        return []
    rows = np.minimum(np.searchsorted(run, np.arange(count + 1) / PARTS, side="left"), run.size - 1)
    spent, way = np.diff(time[rows]), np.diff(turned[rows])
    straight = (np.abs(way) >= _STRAIGHT * np.diff(run[rows])) & (spent > 0)
    speed = np.where(straight, way / np.where(spent > 0, spent, 1.0), 0.0)
    out = []
    for first, last in _runs_of_equal_speed(speed):
        begin, end = first + (first > 0), last - (last < count)
        stretch = slice(int(rows[begin]), run.size if end == count else int(rows[end]))
        if end - begin >= PARTS and time[stretch.stop - 1] - time[stretch.start] >= LEAST_S:
            out.append(stretch)
    return out


def _runs_of_equal_speed(speed: FloatArray) -> list[tuple[int, int]]:
    """First and last + 1 of the runs of speeds (n,) of one sign that lie within ``WITHIN`` of their middle."""
    out: list[tuple[int, int]] = []
    begin, low, high = 0, np.inf, -np.inf
    for k, value in enumerate([*speed.tolist(), 0.0]):
        lower, upper = min(low, value), max(high, value)
        if value != 0.0 and upper - lower <= WITHIN * abs(upper + lower):
            low, high = lower, upper
            continue
        if k > begin:
            out.append((begin, k))
        begin, low, high = (k, value, value) if value != 0.0 else (k + 1, np.inf, -np.inf)
    return out
