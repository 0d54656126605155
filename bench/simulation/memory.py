"""States of terms with a memory, simulated along the rows of each recording (compiled)."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numba
import numpy as np

from bench.simulation.frame import FloatArray, Frame, gone_through, recording_starts
from bench.simulation.states import lag_along, limited_along, play_along, relax, relax_along, worked_along

Between = Literal["fresh", "kept", "released", "followed"]
"""what a state does between recordings: begins at 0 in each; stays; follows the input to 0 and on from there; or from
the last value to the next
"""
NOISE_SHARE = 0.1
"""of the width of a loop: play that keeps a sensor's noise from turning it"""
RATES = (0.2, 0.8, 3.0)
"""1/s at which a loop forgets where its input wavers: a control loop's wavering of a few hertz by a hundredth to a
tenth of the loop's width
"""
RATES_IN_MOTION = (0.1, 0.5, 2.5)
"""1/rad at which a loop forgets where its input wavers with the angle: as much as it turns by over its width, so a
torque of order 100 with an amplitude of a six-hundredth to a twenty-fifth of the loop's width
"""
FEW = 5
"""rows whose mean tells the temperature at which a recording begins or ends"""
_CLOCK = ("recording", "time", "elapsed", "step")
"""what states need of a frame beside what drives them"""
_CODES: dict[Between, int] = {"fresh": 0, "kept": 1, "released": 2, "followed": 3}


def begins(state: str, between: Between) -> str:
    """What an equation says of a state between recordings."""
    if between == "fresh":
        return f"{state} = 0 before each recording"
    way = {"released": " by way of an input of 0", "followed": " as its input does"}.get(between, "")
    return f"{state} goes on between recordings{way}"


@numba.njit(cache=True)
def _relaxing(
    x: FloatArray, forgotten: FloatArray, height: FloatArray, starts: np.ndarray, scale: float, between: int
) -> FloatArray:
    out = np.empty(x.size)
    z = 0.0
    previous = 0.0
    for r in range(starts.size - 1):
        a, b = starts[r], starts[r + 1]
        if between == 0:
            z = 0.0
        if between == 2:
            if previous != 0.0:
                z = relax(z, -previous, scale)
            previous = 0.0
        elif between != 3:
            previous = x[a]
        z, previous = relax_along(x[a:b], forgotten[a:b], height[a:b], out[a:b], z, previous, scale)
    return out


@numba.njit(cache=True)
def _play(x: FloatArray, starts: np.ndarray, half_width: float, between: int) -> FloatArray:
    out = np.empty(x.size)
    p = 0.0
    for r in range(starts.size - 1):
        a, b = starts[r], starts[r + 1]
        if between == 0:
            p = 0.0
        elif between == 2:
            p = min(max(p, -half_width), half_width)
        p = play_along(x[a:b], out[a:b], p, half_width)
    return out


@numba.njit(cache=True)
def _lag(x: FloatArray, dt: FloatArray, starts: np.ndarray, constant: float) -> FloatArray:
    out = np.empty(x.size)
    for r in range(starts.size - 1):
        a, b = starts[r], starts[r + 1]
        y = x[a]
        for i in range(a, b):
            y = x[i] + (y - x[i]) * np.exp(-dt[i] / constant)
            out[i] = y
    return out


@numba.njit(cache=True)
def _followed(x: FloatArray, dt: FloatArray, starts: np.ndarray, constant: float) -> FloatArray:
    out = np.empty(x.size)
    for r in range(starts.size - 1):
        a, b = starts[r], starts[r + 1]
        out[a] = x[a]
        lag_along(x[a + 1 : b], dt[a + 1 : b], out[a + 1 : b], x[a], x[a], constant)
    return out


def relaxing(
    x: FloatArray,
    frame: Frame,
    scale: float,
    between: Between = "fresh",
    rate: float | FloatArray = 0.0,
    height: float | FloatArray = 1.0,
) -> FloatArray:
    """State z that relaxes to a ``height`` h by the sign of dx over a distance ``scale`` and is forgotten at a ``rate``
    (1/s), each a number or one for each row (n,): dz = (1 − z·sgn(dx)/h)·dx/scale − z·rate·dt (Dahl, i = 1).

    An input that wavers to and fro by less than a row shows makes the state forget: of what it turns through,
    |dx|, z loses z·|dx|/scale.
    """
    if not isinstance(x, np.ndarray):
        from_zero = between in ("released", "followed")
        return x.remembered("relaxing", scale, float(from_zero), beside=(rate, height))
    forgotten = np.ascontiguousarray(rate * frame.step)
    heights = np.full(x.size, height) if np.ndim(height) == 0 else np.ascontiguousarray(height)
    if frame.memory is not None:
        return frame.memory.relaxing(np.ascontiguousarray(x), forgotten, heights, scale)
    starts = recording_starts(frame)
    return np.asarray(_relaxing(np.ascontiguousarray(x), forgotten, heights, starts, scale, _CODES[between]))


def play(x: FloatArray, frame: Frame, half_width: float, between: Between = "fresh") -> FloatArray:
    """Play (backlash) operator of half width ``half_width`` in the unit of x."""
    if not isinstance(x, np.ndarray):
        return x.remembered("play", half_width)
    if frame.memory is not None:
        return frame.memory.play(np.ascontiguousarray(x), half_width)
    return np.asarray(_play(np.ascontiguousarray(x), recording_starts(frame), half_width, _CODES[between]))


def taken_along(x: FloatArray, frame: Frame, reach: float) -> FloatArray:
    """How far something is wound up that x takes along until it slips at ``reach`` (stop operator), in the unit of x.
    It goes on between recordings, and the campaign begins with nothing wound up.
    """
    if not isinstance(x, np.ndarray):
        since = x - x.remembered("begun", 0.0)
    elif frame.memory is not None:
        since = x - frame.memory.first(x)
    else:
        since = x - x[:1]
    return since - play(since, frame, reach, "kept")


def limited_integral(x: FloatArray, frame: Frame, limit: float) -> FloatArray:
    """Time integral of x that stops at ``limit`` to either side (trapezoids), in the unit of x times s.

    It goes on between recordings, over which x counts as 0, and the campaign begins at 0.
    """
    if not isinstance(x, np.ndarray):
        return x.remembered("limited_integral", limit)
    if frame.memory is not None:
        return frame.memory.limited_integral(np.ascontiguousarray(x), frame.step, limit)
    # rows of unequal length are as far apart as their middles; before its first a recording is as it is there
    apart = np.diff(frame.time, prepend=frame.time[:1])
    mean = 0.5 * (x + np.concatenate((x[:1], x[:-1])))
    starts = recording_starts(frame)[:-1]
    apart[starts], mean[starts] = frame.elapsed[starts], x[starts]
    out = np.empty(x.size)
    limited_along(mean * apart, out, 0.0, limit)
    return out


def worked_up(x: FloatArray, frame: Frame, rest: float, motion: float) -> FloatArray:
    """How far motion has worked something up that rest restores, from 0 to 1: x is 1 where something moves and 0 where
    it stands; it comes with the time constant ``motion`` and goes with ``rest``, in s.

    It goes on between recordings, over which nothing moves, and the campaign begins at 0.
    """
    if not isinstance(x, np.ndarray):
        return x.remembered("worked_up", rest, motion)
    if frame.memory is not None:
        return frame.memory.worked(np.ascontiguousarray(x), frame.step, rest, motion)
    # from the middle of a row to that of the next the first half is as the one, the second as the other
    half = 0.5 * np.diff(frame.time, prepend=frame.time[:1])
    before, own, moved = half.copy(), half.copy(), np.concatenate((x[:1], x[:-1]))
    starts = recording_starts(frame)[:-1]
    own[starts], moved[starts] = frame.elapsed[starts], 0.0
    before[starts] = np.maximum(2.0 * half[starts] - own[starts], 0.0)
    out = np.empty(x.size)
    worked_along(np.ascontiguousarray(x), moved, before, own, out, 0.0, rest, motion)
    return out


def through(
    driving: Callable[[Frame], FloatArray], frame: Frame, state: Callable[[FloatArray, Frame], FloatArray]
) -> FloatArray:
    """A state that a ``driving`` quantity moves, at the rows of a frame (n,); it goes on through rows aside of them."""
    x, aside = driving(frame), frame.aside
    if aside is None:
        return state(x, frame)
    order = np.argsort(np.concatenate((frame.recording, aside.recording)), kind="stable")
    clock: dict[str, Any] = {
        name: np.concatenate((getattr(frame, name), getattr(aside, name)))[order] for name in _CLOCK
    }
    out = np.empty(order.size)
    out[order] = state(np.concatenate((x, driving(aside)))[order], replace(frame, aside=None, **clock))
    return out[: frame.size]


def lag(x: FloatArray, frame: Frame, constant: float) -> FloatArray:
    """First-order lag of x with the time constant ``constant`` in s, from the recording's first value."""
    if not isinstance(x, np.ndarray):
        return x.remembered("lag", constant)
    return np.asarray(_lag(np.ascontiguousarray(x), _apart(frame), recording_starts(frame), constant))


def followed(x: FloatArray, frame: Frame, constant: float) -> FloatArray:
    """First-order lag of what runs straight from row to row, from the recording's first value."""
    if not isinstance(x, np.ndarray):
        return x.remembered("campaign_lag", constant)
    return np.asarray(_followed(np.ascontiguousarray(x), _apart(frame), recording_starts(frame), constant))


def _apart(frame: Frame) -> FloatArray:
    """Time from the middle of the row before (n,), s: a last row that is shorter lasts less than it is apart. In the
    first row of a recording it says nothing.
    """
    return np.diff(frame.time, prepend=frame.time[:1])


def integral(x: FloatArray, frame: Frame) -> FloatArray:
    """Time integral of x within each recording (trapezoids), 0 in its first row."""
    if not isinstance(x, np.ndarray):
        return x.remembered("integral")
    before = np.concatenate((x[:1], x[:-1]))
    area = 0.5 * (x + before) * _apart(frame)
    starts = recording_starts(frame)[:-1]
    area[starts] = 0.0
    total = np.cumsum(area)
    begun = np.repeat(total[starts], np.diff(np.append(starts, frame.size)))
    return np.asarray(total - begun)


def warmed_between(frame: Frame) -> FloatArray:
    """K (n,) by which recordings have begun warmer than the one before ended, summed up to each row's recording: what
    ran in between, and was not recorded, has warmed the gearbox.
    """
    if not isinstance(frame.temperature, np.ndarray) or frame.memory is not None:
        return frame.temperature * 0.0  # one motion without recordings, and nothing between them
    whole = gone_through(frame)
    starts = recording_starts(whole)
    each = [whole.temperature[a:b] for a, b in itertools.pairwise(starts)]
    first, last = np.array([part[:FEW].mean() for part in each]), np.array([part[-FEW:].mean() for part in each])
    # a reading that is missing tells no rise
    warmer = np.nan_to_num(np.maximum(first[1:] - last[:-1], 0.0))
    by_recording = np.zeros(int(whole.recording.max()) + 1)
    by_recording[whole.recording[starts[:-1]]] = np.append(0.0, np.cumsum(warmer))
    return np.asarray(by_recording[frame.recording])


def campaign_lag(x: FloatArray, frame: Frame, constant: float) -> FloatArray:
    """First-order lag that goes on between recordings: over a gap x runs straight from one value to the next."""
    if not isinstance(x, np.ndarray):
        return x.remembered("campaign_lag", constant)
    if frame.memory is not None:
        return frame.memory.campaign_lag(np.ascontiguousarray(x), frame.step, constant)
    return np.asarray(_campaign_lag(np.ascontiguousarray(x), frame.time, constant))


def loss_lag(frame: Frame, constant: float) -> FloatArray:
    """First-order lag of the loss, W, that goes on between recordings: before one that begins at rest nothing is lost,
    before another the loss runs straight from one value to the next.
    """
    loss = frame.power
    if not isinstance(loss, np.ndarray) or frame.memory is not None:
        return campaign_lag(loss, frame, constant)
    starts = recording_starts(frame)[:-1]
    resting = starts[frame.direction[starts] == 0]
    half = frame.elapsed[resting]
    begins = frame.time[resting] - half
    before = np.where(resting > 0, frame.time[resting - 1], begins)
    begins = np.maximum(begins, before)
    # the one before ends half a row after the middle of its last
    ended = np.minimum(before + half, begins)
    at = np.repeat(resting, 2)
    time = np.insert(frame.time, at, np.column_stack([ended, begins]).ravel())
    out = _campaign_lag(np.insert(loss, at, 0.0), time, constant)
    return np.asarray(np.delete(out, at + np.arange(at.size)))


@numba.njit(cache=True)
def _campaign_lag(x: FloatArray, time: FloatArray, constant: float) -> FloatArray:
    out = np.empty(x.size)
    dt = np.zeros(x.size)
    dt[1:] = time[1:] - time[:-1]
    lag_along(x, dt, out, x[0], x[0], constant)
    return out
