"""Rows of one channel: what a block of samples says. Three reductions of the same recordings.

Torques are reduced in time, finer where speed or load change; the transmission error over the angle, finer than any
order it is asked for; the temperature in blocks of two seconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.prepared import Prepared
from bench.mismatch.recordings.thinning import Measured
from bench.simulation.frame import ARRAYS, FloatArray, Frame, IntArray, concatenate
from bench.simulation.memory import integral

SLOW_S = 1.0
"""longest block of a torque's rows: noise of a bench forgets itself in about as long"""
LIVELY_S = 0.02
"""longest block just after a start or a reversal, and the shortest elsewhere"""
ROWS_A_WINDOW = 2.0
"""of the rates of a free motion, at least: what the window lets pass is not averaged away in a row"""
HEAT_S = 2.0
"""block of the temperature's rows: its time constants are minutes"""
TORQUE_STEP = 0.17
"""rad at the output: longest row of a torque, a sixth of a period of order six"""
MOST_STEPS = 0.5
"""readings of different value, over all readings, above which steps are not seen"""
ARITHMETIC = 1e-9
"""of the largest reading, below which two are the same: a scaled integer is known to 16 digits"""
ANGLE_STEP = 1.2e-3
"""rad at the output: 5,236 rows a revolution, two a period of order 2,618"""
ANGLE_STEP_S = 0.1
"""longest row of the transmission error where the bench hardly turns"""
_CHANGES = 40
"""parts of the largest speed, and of the largest load, by which they may change inside a block"""
_MOSTLY = 90.0
"""percentile of the changes within the shortest block"""
JUST_AFTER_S, _JUST_AFTER_RAD = 1.5, 0.05
"""time and distance after a start or reversal in which blocks are short"""


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of one channel: frame, means ``y`` over the valid samples of each block, how ``number`` they are.

    ``within``: variance of the samples inside a block, where it is kept; of a thermometer no less than its rounding's.
    Where the channel is compared over the angle: ``lean``, their covariance with the angle there; ``sweep``, variance
    of the angle there. Empty where it is not.
    """

    frame: Frame
    y: FloatArray
    number: FloatArray
    within: FloatArray = field(default_factory=lambda: np.zeros(0))
    lean: FloatArray = field(default_factory=lambda: np.zeros(0))
    sweep: FloatArray = field(default_factory=lambda: np.zeros(0))

    def take(self, rows: NDArray[np.bool_] | IntArray | slice) -> Rows:
        """Return the rows chosen (mask, indices or slice)."""
        inner = [a[rows] if a.size else a for a in (self.within, self.lean, self.sweep)]
        return Rows(self.frame.take(rows), self.y[rows], self.number[rows], *inner)

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self.y.size)


def join(parts: Sequence[Rows]) -> Rows:
    """Rows of several recordings as one."""
    names = ("y", "number", "within", "lean", "sweep")
    return Rows(concatenate([p.frame for p in parts]), *(np.concatenate([getattr(p, n) for p in parts]) for n in names))


def lively(frame: Frame) -> NDArray[np.bool_]:
    """Rows just after a start or a reversal."""
    return np.asarray((frame.reversal_time < JUST_AFTER_S) & (frame.reversal_travel < _JUST_AFTER_RAD))


def settled_rows(frame: Frame) -> NDArray[np.bool_]:
    """Rows in steady motion that no start or reversal is felt in any more: where noise is measured."""
    return np.asarray((frame.steady > 0.5) & ~lively(frame))


def slow_rows(prepared: Prepared, channel: str, manner: Manner) -> Rows:
    """Rows of a torque; blocks end by parts of the folder's largest load and speed.

    A motion that follows no set speeds goes as far as it goes, and its load is what it is.
    """
    free = manner.free
    torque = manner.torque or 1.0 if free else max(manner.torque, 1.0)
    frame, rate = prepared.frame, prepared.sample_rate
    briefest = min(LIVELY_S, manner.smoothing / ROWS_A_WINDOW) if free else LIVELY_S
    shortest = max(1.0, round(briefest * rate))
    width = np.where(lively(frame), shortest, max(1.0, round(SLOW_S * rate)))
    step = min(TORQUE_STEP, float(np.ptp(frame.q)) / _CHANGES) if free else TORQUE_STEP
    samples_per_step = step * rate / np.maximum(np.abs(frame.velocity), 1e-12)
    width = np.minimum(width, np.maximum(samples_per_step, shortest))
    parting: IntArray = np.cumsum(changed(frame.direction, prepared.label, prepared.corner))
    limits = changes(torque, manner.speed)
    if free:
        limits = np.maximum(limits, _in_a_moment(frame, max(1, round(shortest))))
    most = np.full(frame.size, 1.0 / shortest)
    edges = blocks(1.0 / width, most, parting, frame.velocity, frame.torque_level, limits)
    measured = prepared.measured[channel]
    mean, number = block_mean(measured.mean, measured.number, edges)
    return Rows(reduced(frame, edges), mean, number, _within(measured, mean, edges, number))


def fine_rows(prepared: Prepared, channel: str, step: float) -> Rows:
    """Rows of a torque, each of ``step`` s, whatever it does in them."""
    edges = np.arange(0, prepared.frame.size, max(1, round(step * prepared.sample_rate)))
    measured = prepared.measured[channel]
    mean, number = block_mean(measured.mean, measured.number, edges)
    return Rows(reduced(prepared.frame, edges), mean, number, _within(measured, mean, edges, number))


def heat_rows(prepared: Prepared) -> Rows:
    """Rows of the temperature."""
    edges = np.arange(0, prepared.frame.size, max(1, round(HEAT_S * prepared.sample_rate)))
    measured = prepared.measured["temperature"]
    mean, number = block_mean(measured.mean, measured.number, edges)
    frame = reduced(prepared.frame, edges)
    heat = prepared.frame.count * integral(prepared.frame.power, prepared.frame)
    heat = np.add.reduceat(heat, edges) / frame.count
    frame = replace(frame, lead=heat - heat[0] - integral(frame.power, frame))
    # readings that stay at one step of the thermometer do not scatter, and are as far off as they were rounded
    rounded = step_of(measured.samples[measured.valid]) ** 2 / 12.0
    return Rows(frame, mean, number, np.maximum(_within(measured, mean, edges, number), rounded))


def step_of(readings: FloatArray) -> float:
    """Step of a sensor: the smallest difference between two readings (n,) that is no rounding of the arithmetic; 0
    where they do not say, for they are all the same or all different.
    """
    values = np.unique(readings[np.isfinite(readings)])
    if values.size < 2 or values.size > MOST_STEPS * readings.size:
        return 0.0
    apart = np.diff(values)
    apart = apart[apart > ARITHMETIC * float(np.abs(values).max())]
    return float(apart.min()) if apart.size else 0.0


def _within(measured: Measured, mean: FloatArray, edges: IntArray, number: FloatArray) -> FloatArray:
    """Variance of the valid samples inside each block."""
    width = np.diff(np.append(edges, measured.number.size))
    inner = np.where(measured.number > 0, measured.mean - np.repeat(mean, width), 0.0)
    return np.asarray(np.add.reduceat(inner**2 * measured.number + measured.scatter, edges) / np.maximum(number, 1.0))


def angle_rows(prepared: Prepared) -> Rows:
    """Rows of the transmission error, with how the samples inside a row follow the angle."""
    frame = prepared.frame
    step = np.abs(frame.velocity) / prepared.sample_rate / ANGLE_STEP
    slowest = 1.0 / (ANGLE_STEP_S * prepared.sample_rate)
    edges = _edges(np.cumsum(np.maximum(step, slowest)), frame.direction, prepared.label)
    measured = prepared.measured["transmission_error"]
    mean, number = block_mean(measured.mean, measured.number, edges)
    width = np.diff(np.append(edges, measured.number.size))
    inner = np.where(measured.number > 0, measured.mean - np.repeat(mean, width), 0.0)
    angle, _ = block_mean(frame.theta, measured.number, edges)
    offset = np.where(measured.number > 0, frame.theta - np.repeat(angle, width), 0.0)
    at_least = np.maximum(number, 1.0)
    within = np.add.reduceat(inner**2 * measured.number + measured.scatter, edges) / at_least
    lean = np.add.reduceat(inner * offset * measured.number + prepared.leaning, edges) / at_least
    sweep = np.add.reduceat(offset**2 * measured.number + prepared.swept, edges) / at_least
    return Rows(reduced(frame, edges), mean, number, within, lean, sweep)


def changes(torque: float, speed: float) -> FloatArray:
    """By how much speed and load may change inside a block (2,), where ``torque`` and ``speed`` are the largest: what
    is no straight line of them has no mean at their means.
    """
    return np.array([speed / _CHANGES, torque / _CHANGES])


def _in_a_moment(frame: Frame, step: int) -> FloatArray:
    """By how much speed and load mostly change within the shortest block of ``step`` samples (2,): noise of a row tells
    more than what bends within it.
    """
    if frame.size <= step:
        return np.zeros(2)
    moved = [np.abs(values[step:] - values[:-step]) for values in (frame.velocity, frame.torque_level)]
    return np.array([float(np.percentile(values, _MOSTLY)) for values in moved])


def changed(*values: NDArray[Any]) -> NDArray[np.bool_]:
    """Where any of the values differs from the one before (n,)."""
    out = np.zeros(values[0].size, dtype=bool)
    for column in values:
        out[1:] |= column[1:] != column[:-1]
    return out


def _edges(progress: FloatArray, *parting: NDArray[Any]) -> IntArray:
    """First index of each block: one ends where ``progress`` passes a whole number or a ``parting`` value changes."""
    change = changed(np.floor(progress), *parting)
    change[0] = True
    return np.flatnonzero(change).astype(np.int64)


@numba.njit(cache=True)
def blocks(
    share: FloatArray, quick: FloatArray, parting: IntArray, speed: FloatArray, torque: FloatArray, limits: FloatArray
) -> IntArray:
    """First index of each block: one ends when its shares make a whole, or speed or torque have changed by a limit.

    ``quick`` (n,): shares of the shortest block. What swings to and fro within that has its mean in it all the same.
    """
    out = np.empty(share.size, dtype=np.int64)
    number = 0
    total, age, v, t = 2.0, 2.0, 0.0, 0.0
    for i in range(share.size):
        changed = age > 1.0 - 1e-9 and (abs(speed[i] - v) > limits[0] or abs(torque[i] - t) > limits[1])
        if total > 1.0 - 1e-9 or changed or parting[i] != parting[i - 1]:
            out[number] = i
            number += 1
            total, age, v, t = 0.0, 0.0, speed[i], torque[i]
        total += share[i]
        age += quick[i]
    return out[:number]


_FIRST = ("recording", "direction", "last_direction", "kept", "steady", "reversed_before")


def reduced(frame: Frame, edges: IntArray) -> Frame:
    """Average a frame over blocks; counts and steps add up, flags are those of the first row."""
    count = np.add.reduceat(frame.count, edges)
    out: dict[str, Any] = {}
    for name in ARRAYS:
        values = getattr(frame, name)
        if name in _FIRST:
            out[name] = values[edges]
        elif name in ("count", "step"):
            out[name] = np.add.reduceat(values, edges)
        else:
            out[name] = np.add.reduceat(values * frame.count, edges) / count
    aux = {name: np.add.reduceat(values * frame.count, edges) / count for name, values in frame.aux.items()}
    return replace(frame, aux=aux, **out)


def block_mean(signal: FloatArray, number_of: FloatArray, edges: IntArray) -> tuple[FloatArray, FloatArray]:
    """Mean over the valid samples of each block, of which each row has ``number_of``; and how many (0: none valid)."""
    number = np.add.reduceat(number_of, edges)
    total = np.add.reduceat(signal * number_of, edges)
    return total / np.maximum(number, 1.0), number


def hardly_acts(added: FloatArray, number: FloatArray, held_out: NDArray[np.bool_], fitted: NDArray[np.bool_]) -> bool:
    """Whether what something adds (n,), ``number`` samples each, has less than half of the mean square per sample in
    the rows held out that it has in the fitted ones: these say nothing of it.
    """

    def size(rows: NDArray[np.bool_]) -> float:
        return float(np.sum(number[rows] * added[rows] ** 2) / max(float(number[rows].sum()), 1e-300))

    return size(held_out) < criteria.EITHER * size(fitted)


def error_of_mean(values: FloatArray, recording: IntArray, number: FloatArray) -> float | None:
    """Standard error of the mean per sample of values (n,), ``number`` samples each, recordings taken as drawn; None
    where they are fewer than two.
    """
    samples = np.bincount(recording, number)
    seen = samples > 0
    if int(seen.sum()) < 2:
        return None
    means = np.bincount(recording, values * number)[seen] / samples[seen]
    share = samples[seen] / samples.sum()
    whole = float(np.sum(share * means))
    return float(np.sqrt(np.sum((share * (means - whole)) ** 2) * means.size / (means.size - 1)))
