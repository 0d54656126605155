"""Moments at which the load torque changes its sign in motion, and what a model leaves after them, and elsewhere.

The load has changed its sign where it was clear of zero on one side before and is clear of it on the other after. Where
the motion turns soon after that, the moment is that of the turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.recordings.rows import JUST_AFTER_S
from bench.mismatch.recordings.vibration import Density
from bench.mismatch.regression.noise import mixture
from bench.simulation.frame import FloatArray, Frame, IntArray

FINE_S = 0.02
"""steps in which what is left is looked at: four of them show a period of 12.5 Hz"""
WINDOW_S = 2.0
"""after a crossing; of what fades more slowly this shows the begin"""
SHORTEST_S = 1.0
"""window after which the motion may end, or the load change its sign again: three halves of the slowest period"""
SOON_S = 0.5
"""from a crossing to the turn that made it: a load that friction holds changes its sign as the motion turns"""
MOST_RECORDINGS = 16
"""that are looked at: each is read once more"""
SURE_OF = 3.0
"""standard deviations of the sensor's noise in a step, beyond which the sign of the load torque counts"""
MISSING = 0.1
"""share of a window that may be missing, and is bridged by straight lines"""
ROUNDING = 1e-6
"""relative error of a difference of times"""


@dataclass(frozen=True, slots=True)
class FineResidual:
    """What a model leaves (n,) of one recording in steps of :data:`FINE_S`, nan where it is not compared; their frame,
    whose ``elapsed`` is the time of each step.
    """

    frame: Frame
    left: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Window:
    """What is left (k,) in a window of a recording that begins at ``start`` s; whether that is just ``after_start`` or
    a reversal.
    """

    recording: int
    start: float
    left: FloatArray
    after_start: bool


def clear_of_zero(densities: Sequence[Density]) -> float | None:
    """Smallest load torque that is distinguished from zero in a step, N·m, by the noise that spectra of the load torque
    show; None where they are too few to tell.
    """
    noise = mixture(densities)
    if noise is None:
        return None
    step = noise.of_means(np.array([noise.rate * FINE_S]), np.array([FINE_S]))
    return SURE_OF * float(np.sqrt(step[0]))


def on_grid(frame: Frame, left: FloatArray, recording: int) -> FineResidual | None:
    """What is ``left`` (n,), nan where nothing is compared, at the rows of a ``frame`` of one recording in steps of
    :data:`FINE_S`: the mean of the rows in each, or the next row where none is; None where rows are longer than two.
    """
    at = np.flatnonzero(frame.recording == recording)
    if at.size < 2:
        return None
    times = frame.elapsed[at]
    if float(np.median(np.diff(times))) > 2.0 * FINE_S * (1.0 + ROUNDING):
        return None
    grid = np.arange(times[0], times[-1], FINE_S)
    next_to = np.searchsorted(0.5 * (times[1:] + times[:-1]), grid)
    step = np.minimum(np.rint((times - times[0]) / FINE_S).astype(np.int64), grid.size - 1)
    good = np.isfinite(left[at])
    number = np.bincount(step[good], minlength=grid.size)
    mean = np.bincount(step[good], left[at][good], grid.size) / np.maximum(number, 1.0)
    # between rows of a gap nothing is known
    near = np.where(np.abs(times[next_to] - grid) > FINE_S * (1.0 + ROUNDING), np.nan, left[at][next_to])
    return FineResidual(replace(frame.take(at[next_to]), elapsed=grid), np.where(number > 0, mean, near))


def to_read(frame: Frame, clear: float, fitted: Sequence[bool]) -> IntArray:
    """Recordings in which a load torque that is ``clear`` of zero changes its sign in motion, those with the most
    first; then others that start or reverse, with which these are compared. At most :data:`MOST_RECORDINGS`, half of
    them others where there are so many, and fitted ones before those held out; none where the load changes its sign in
    none.
    """
    moving = np.flatnonzero((frame.direction != 0) & np.isfinite(frame.torque_level))
    size = 1 + int(frame.recording.max(initial=0))
    crossed, turned = np.zeros(size), np.zeros(size)
    sides = moving[np.abs(frame.torque_level[moving]) > clear]
    for out, rows, values in ((crossed, sides, frame.torque_level), (turned, moving, frame.direction)):
        recording, sign = frame.recording[rows], np.sign(values[rows])
        out += np.bincount(recording[1:][(recording[1:] == recording[:-1]) & (sign[1:] != sign[:-1])], minlength=size)
    held_out = ~np.asarray(fitted, dtype=bool)[:size]
    others = np.lexsort((-turned, held_out))
    others = others[(crossed[others] == 0) & np.isin(others, frame.recording[moving]) & ~held_out[others]]
    first = np.lexsort((-crossed, held_out))
    first = first[crossed[first] > 0][: MOST_RECORDINGS - min(others.size, MOST_RECORDINGS // 2)]
    return np.concatenate((first, others))[:MOST_RECORDINGS] if first.size else first


def crossings(frame: Frame, clear: float) -> IntArray:
    """Steps of a recording in motion at which a load torque that is ``clear`` of zero has changed its sign, or the
    first after a turn that comes soon.
    """
    torque = frame.torque
    sides = np.flatnonzero(np.abs(torque) > clear)
    sign = np.sign(torque[sides])
    changed = np.flatnonzero(sign[1:] != sign[:-1])
    turned = _turned(frame)
    out: list[int] = []
    soon = round(SOON_S / FINE_S)
    for a, b in zip(sides[changed], sides[changed + 1], strict=True):
        k = a + 1 + int(np.argmin(np.abs(torque[a + 1 : b + 1])))
        begins = [k, *turned[(turned > k) & (turned <= k + soon)].tolist()]
        out += [begin for begin in begins if frame.direction[begin] != 0][-1:]
    return np.unique(np.asarray(out, dtype=np.int64))


def _turned(frame: Frame) -> IntArray:
    """Steps at which the motion starts, ends or turns."""
    return np.asarray(np.flatnonzero(np.diff(frame.direction) != 0) + 1)


def windows(residual: FineResidual, clear: float) -> tuple[list[Window], list[Window]]:
    """Windows after crossings, and reference windows, which follow none. How a recording that begins in motion was
    started is not known: its first :data:`~bench.mismatch.recordings.rows.JUST_AFTER_S` are no reference.
    """
    frame = residual.frame
    longest, shortest, soon = (round(length / FINE_S) for length in (WINDOW_S, SHORTEST_S, SOON_S))
    turned, at = _turned(frame), crossings(frame, clear)
    after_start = np.zeros(frame.size, dtype=bool)
    for k in turned:
        after_start[k : k + round(JUST_AFTER_S / FINE_S)] = True
    taken = np.zeros(frame.size, dtype=bool)
    for k in at:
        taken[max(k - soon, 0) : k + longest] = True
    if frame.size and frame.direction[0] != 0:
        taken[: round(JUST_AFTER_S / FINE_S)] = True
    edges = np.flatnonzero(np.diff(taken)) + 1
    ends = np.unique(np.concatenate((turned, at, [frame.size])))

    def window(begin: int, ends: IntArray) -> Window | None:
        end = min(int(ends[np.searchsorted(ends, begin, side="right")]), begin + longest)
        if end - begin < shortest or not np.all(frame.direction[begin:end]):
            return None
        left = _bridged(residual.left[begin:end])
        if left is None:
            return None
        return Window(int(frame.recording[0]), float(frame.elapsed[begin]), left, bool(after_start[begin]))

    found = [w for w in (window(k, ends) for k in at.tolist()) if w is not None]
    reference: list[Window] = []
    parts = np.unique(np.concatenate((ends, edges)))
    begins = np.unique(np.concatenate(([0], turned, edges)))
    for part in begins[begins < frame.size].tolist():
        last = int(parts[np.searchsorted(parts, part, side="right")])
        for begin in range(part, last, longest):
            one = None if taken[begin] else window(begin, parts)
            reference += [] if one is None else [one]
    return found, reference


def _bridged(left: FloatArray) -> FloatArray | None:
    """What is left in a window, with what is missing bridged; None where that is too much."""
    good: NDArray[np.bool_] = np.isfinite(left)
    if np.mean(~good) > MISSING:
        return None
    steps = np.arange(left.size)
    return left if good.all() else np.asarray(np.interp(steps, steps[good], left[good]))
