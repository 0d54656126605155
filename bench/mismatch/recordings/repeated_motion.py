"""Whether recordings held out repeat the motion of those that are fitted.

A function that follows one motion predicts the same motion as well when it was recorded again. What is left there says
how large the noise is, and not whether the function holds for another motion. Other quantities that were recorded are
part of a motion: other joints of an arm may move otherwise.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from scipy.signal import correlate

from bench.mismatch.recordings.motion import NOTED
from bench.simulation.frame import FloatArray, Frame

STEPS = 400
"""of a recording held out, in which its speed is compared"""
ALIKE = 0.05
"""energy by which two speeds differ, over that of both, up to which they are one motion"""
OVERLAP = 0.9
"""share of a recording held out that has to lie beside the fitted one"""


def repeats(frame: Frame, held_out: Collection[int]) -> list[str]:
    """What is said where nearly all recordings held out repeat the motion of a fitted one, by the rows of all."""
    numbers = [int(n) for n in np.unique(frame.recording) if np.any(frame.velocity[frame.recording == n])]
    held = [n for n in numbers if n in held_out]
    fitted = [n for n in numbers if n not in held_out]
    again = sum(any(_is_part(frame, number, of) for of in fitted) for number in held)
    if not held or not fitted or again < (1.0 - NOTED) * len(held):
        return []
    return [
        "the recordings held out repeat the motion of fitted ones: what is left of them says how large the noise is,"
        " and not how another motion would be predicted"
    ]


def _is_part(frame: Frame, number: int, of: int) -> bool:
    """Whether the motion of one recording is that of a part of another."""
    (time, course), (other_time, other_course) = (_course(frame, n) for n in (number, of))
    step = float(time[-1] - time[0]) / STEPS
    if step <= 0.0 or other_time[-1] - other_time[0] < OVERLAP * STEPS * step:
        return False
    at, grid = np.arange(time[0], time[-1], step), np.arange(other_time[0], other_time[-1], step)
    # a little more on either side: the end of the one may lie beyond that of the other
    beyond = round((1.0 - OVERLAP) * at.size)
    if grid.size + 2 * beyond < at.size:
        return False
    apart, both = np.zeros(1), np.zeros(1)
    for values, other_values in zip(course, other_course, strict=True):
        one = np.interp(at, time, values)
        other = np.pad(np.interp(grid, other_time, other_values), beyond, mode="edge")
        summed = np.concatenate(([0.0], np.cumsum(other**2)))
        energy = summed[one.size :] - summed[: -one.size] + float(one @ one)
        both = both + energy
        apart = apart + energy - 2.0 * correlate(other, one, mode="valid")
    return bool(np.any(apart <= ALIKE * np.maximum(both, 1e-300)))


def _course(frame: Frame, number: int) -> tuple[FloatArray, list[FloatArray]]:
    """Time since the begin of a recording, and its speed and all that is no channel of the bench, each in units of its
    size in all recordings, row by row.
    """
    rows = frame.recording == number
    quantities = [frame.velocity, *(v - np.nanmean(v) for v in frame.aux.values())]
    scaled = [v[rows] / max(float(np.sqrt(np.nanmean(v**2))), 1e-300) for v in quantities if np.isfinite(v).all()]
    return frame.elapsed[rows], scaled
