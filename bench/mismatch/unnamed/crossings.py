"""Moments at which the load torque passes zero in motion, and what a model leaves after them, and elsewhere.

The load has passed zero where it was surely on one side before and is surely on the other after: by a few standard
deviations of its sensor. Where the motion turns soon after that, the moment is that of the turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.recordings.vibration import Density
from bench.mismatch.regression.noise import mixture
from bench.simulation.frame import FloatArray, Frame, IntArray

FINE_S = 0.02
"""steps in which what is left is looked at: four of them show a period of 12.5 Hz"""
WINDOW_S = 2.0
"""after a crossing; of what fades more slowly this shows the begin"""
SHORTEST_S = 1.0
"""window after which the motion may end, or the load cross zero again: three halves of the slowest period"""
AFTER_S = 1.5
"""time after a start or a reversal in which the control loops are felt (as long as rows are short there)"""
SOON_S = 0.5
"""from a crossing to the turn that made it: a load that friction holds changes its side as the motion turns"""
MOST_RECORDINGS = 16
"""that are looked at: each is read once more"""
SURE_OF = 3.0
"""standard deviations of the sensor about zero that are no side"""
MISSING = 0.1
"""share of a window that may be missing, and is bridged by straight lines"""


@dataclass(frozen=True, slots=True)
class Finely:
    """What a model leaves (n,) of one recording in steps of :data:`FINE_S`, nan where it is not compared; their frame,
    whose ``elapsed`` is the time of each step.
    """

    frame: Frame
    left: FloatArray


@dataclass(frozen=True, slots=True)
class Window:
    """What is left (k,) in a window of a recording that begins at ``start`` s; whether a start or reversal is felt in
    it.
    """

    recording: int
    start: float
    left: FloatArray
    lively: bool


def sure_load(densities: Sequence[Density]) -> float:
    """Load torque that is surely no zero, N·m, by the noise that spectra of the load torque show; 0 where they are too
    few to tell.
    """
    noise = mixture(densities)
    return 0.0 if noise is None else SURE_OF * float(np.sqrt(noise.variance))


def on_grid(frame: Frame, left: FloatArray, recording: int) -> Finely | None:
    """What is ``left`` (n,), nan where nothing is compared, at the rows of a ``frame`` of one recording in steps of
    :data:`FINE_S`: the mean of the rows in each, or the next row where none is; None where rows are longer than two.
    """
    at = np.flatnonzero(frame.recording == recording)
    if at.size < 2:
        return None
    times = frame.elapsed[at]
    if float(np.median(np.diff(times))) > 2.0 * FINE_S:
        return None
    grid = np.arange(times[0], times[-1], FINE_S)
    nearest = at[np.searchsorted(0.5 * (times[1:] + times[:-1]), grid)]
    step = np.minimum(np.rint((times - times[0]) / FINE_S).astype(np.int64), grid.size - 1)
    good = np.isfinite(left[at])
    number = np.bincount(step[good], minlength=grid.size)
    mean = np.bincount(step[good], left[at][good], grid.size) / np.maximum(number, 1.0)
    return Finely(replace(frame.take(nearest), elapsed=grid), np.where(number > 0, mean, left[nearest]))


def to_read(frame: Frame, sure: float, fitted: Sequence[bool]) -> IntArray:
    """Recordings in which a load torque of more than ``sure`` changes its side in motion, those with the most first;
    then others that start or reverse, with which these are compared. At most :data:`MOST_RECORDINGS`, half of them
    others, and fitted ones before those held out; none where the load passes zero in none.
    """
    moving = np.flatnonzero((frame.direction != 0) & np.isfinite(frame.torque_level))
    size = 1 + int(frame.recording.max(initial=0))
    crossed, turned = np.zeros(size), np.zeros(size)
    sides = moving[np.abs(frame.torque_level[moving]) > sure]
    for out, rows, values in ((crossed, sides, frame.torque_level), (turned, moving, frame.direction)):
        recording, sign = frame.recording[rows], np.sign(values[rows])
        out += np.bincount(recording[1:][(recording[1:] == recording[:-1]) & (sign[1:] != sign[:-1])], minlength=size)
    held_out = ~np.asarray(fitted, dtype=bool)[:size]
    first = np.lexsort((-crossed, held_out))
    first = first[crossed[first] > 0][: MOST_RECORDINGS // 2]
    if first.size == 0:
        return first
    others = np.lexsort((-turned, held_out))
    others = others[(crossed[others] == 0) & np.isin(others, frame.recording[moving]) & ~held_out[others]]
    return np.concatenate((first, others))[:MOST_RECORDINGS]


def crossings(frame: Frame, sure: float) -> IntArray:
    """Steps of a recording in motion at which a load torque of more than ``sure`` has changed its side, or the first
    after a turn that comes soon.
    """
    torque = frame.torque
    sides = np.flatnonzero(np.abs(torque) > sure)
    sign = np.sign(torque[sides])
    changed = np.flatnonzero(sign[1:] != sign[:-1])
    turned = np.flatnonzero(np.diff(frame.direction) != 0) + 1
    out: list[int] = []
    soon = round(SOON_S / FINE_S)
    for a, b in zip(sides[changed], sides[changed + 1], strict=True):
        k = a + 1 + int(np.argmin(np.abs(torque[a + 1 : b + 1])))
        begins = [k, *turned[(turned > k) & (turned <= k + soon)].tolist()]
        out += [begin for begin in begins if frame.direction[begin] != 0][-1:]
    return np.unique(np.asarray(out, dtype=np.int64))


def windows(finely: Finely, sure: float) -> tuple[list[Window], list[Window]]:
    """Windows after crossings, and those that follow none."""
    frame = finely.frame
    longest, shortest, soon = (round(length / FINE_S) for length in (WINDOW_S, SHORTEST_S, SOON_S))
    turned = np.flatnonzero(np.diff(frame.direction) != 0) + 1
    at = crossings(frame, sure)
    struck = np.zeros(frame.size, dtype=bool)
    for k in at:
        struck[max(k - soon, 0) : k + longest] = True
    edges = np.flatnonzero(np.diff(struck)) + 1
    ends = np.unique(np.concatenate((turned, at, [frame.size])))

    def window(begin: int, ends: IntArray) -> Window | None:
        end = min(int(ends[np.searchsorted(ends, begin, side="right")]), begin + longest)
        if end - begin < shortest or not np.all(frame.direction[begin:end]):
            return None
        left = _bridged(finely.left[begin:end])
        lively = bool(frame.reversal_time[begin] < AFTER_S)
        return None if left is None else Window(int(frame.recording[0]), float(frame.elapsed[begin]), left, lively)

    found = [w for w in (window(k, ends) for k in at.tolist()) if w is not None]
    rest: list[Window] = []
    parts = np.unique(np.concatenate((ends, edges)))
    begins = np.unique(np.concatenate(([0], turned, edges)))
    for part in begins[begins < frame.size].tolist():
        last = int(parts[np.searchsorted(parts, part, side="right")])
        for begin in range(part, last, longest):
            one = None if struck[begin] else window(begin, parts)
            rest += [] if one is None else [one]
    return found, rest


def _bridged(left: FloatArray) -> FloatArray | None:
    """What is left in a window, with what is missing bridged; None where that is too much."""
    good: NDArray[np.bool_] = np.isfinite(left)
    if np.mean(~good) > MISSING:
        return None
    steps = np.arange(left.size)
    return left if good.all() else np.asarray(np.interp(steps, steps[good], left[good]))
