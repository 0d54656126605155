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

Course = tuple[FloatArray, list[FloatArray]]
"""of a recording: time since its begin, and its speed and all that is no channel of the bench, row by row"""
STEPS = 400
"""of a recording held out, in which its speed is compared"""
ALIKE = 0.05
"""energy by which two speeds differ, over that of both, up to which they are one motion"""
OVERLAP = 0.9
"""share of a recording held out that has to lie beside the fitted one"""


def repeats(frame: Frame, held_out: Collection[int]) -> list[str]:
    """What is said where nearly all recordings held out repeat the motion of a fitted one, by the rows of all."""
    courses = _courses(frame)
    held = [course for number, course in courses.items() if number in held_out]
    fitted = [course for number, course in courses.items() if number not in held_out]
    again = sum(any(_is_part(one, of) for of in fitted) for one in held)
    if not held or not fitted or again < (1.0 - NOTED) * len(held):
        return []
    return [
        "the recordings held out repeat the motion of fitted ones: what is left of them says how large the noise is,"
        " and not how another motion would be predicted"
    ]


def _is_part(one: Course, of: Course) -> bool:
    """Whether the motion of one recording is that of a part of another."""
    (time, course), (other_time, other_course) = one, of
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
        part = np.interp(at, time, values)
        other = np.pad(np.interp(grid, other_time, other_values), beyond, mode="edge")
        summed = np.concatenate(([0.0], np.cumsum(other**2)))
        energy = summed[part.size :] - summed[: -part.size] + float(part @ part)
        both = both + energy
        apart = apart + energy - 2.0 * correlate(other, part, mode="valid")
    return bool(np.any(apart <= ALIKE * np.maximum(both, 1e-300)))


def _courses(frame: Frame) -> dict[int, Course]:
    """Courses of the recordings that move, each in units of its size in all recordings."""
    quantities = [frame.velocity, *(v - np.nanmean(v) for v in frame.aux.values())]
    scaled = [v / max(float(np.sqrt(np.nanmean(v**2))), 1e-300) for v in quantities if np.isfinite(v).all()]
    out = {}
    for number in np.unique(frame.recording).tolist():
        rows = frame.recording == number
        if np.any(frame.velocity[rows]):
            out[number] = frame.elapsed[rows], [v[rows] for v in scaled]
    return out
