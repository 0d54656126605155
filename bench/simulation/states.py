"""States that follow an input: one that relaxes to the sign of its change, and play (compiled); and what keeps them."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@numba.njit(cache=True)
def relax(z: float, step: float, scale: float, forgotten: float = 0.0, height: float = 1.0) -> float:
    """The relaxing state after a step of its input; ``forgotten``: rate of forgetting times the step's duration;
    ``height``: how far it relaxes.
    """
    push = abs(step) / scale
    loss = push / height + forgotten
    if loss == 0.0:
        return float(z)
    target = (1.0 if step > 0 else -1.0) * push / loss
    return float(target + (z - target) * np.exp(-loss))


@numba.njit(cache=True)
def relax_along(
    x: FloatArray, forgotten: FloatArray, height: FloatArray, out: FloatArray, z: float, previous: float, scale: float
) -> tuple[float, float]:
    """Fill ``out`` (n,) with the state along x, from a state and the input before it; both as they are at the end.

    ``forgotten`` (n,): rate of forgetting times the time since the row before; ``height`` (n,): how far it relaxes.
    """
    for i in range(x.size):
        step = x[i] - previous
        previous = x[i]
        z = relax(z, step, scale, forgotten[i], height[i])
        out[i] = z
    return z, previous


@numba.njit(cache=True)
def play_along(x: FloatArray, out: FloatArray, p: float, half_width: float) -> float:
    """Fill ``out`` (n,) with the play along x, from where it stood; where it stands at the end."""
    for i in range(x.size):
        p = min(max(p, x[i] - half_width), x[i] + half_width)
        out[i] = p
    return p


@numba.njit(cache=True)
def lag_along(x: FloatArray, dt: FloatArray, out: FloatArray, y: float, previous: float, constant: float) -> float:
    """Fill ``out`` (n,) with a first-order lag of x, from its value and the input before it; its value at the end.

    Over ``dt`` (n,) s since the row before x runs straight from one value to the next.
    """
    for i in range(x.size):
        if dt[i] > 0.0:
            slope = (x[i] - previous) / dt[i]
            # exact response of the lag to a ramp
            steady, begin = x[i] - slope * constant, previous - slope * constant
            y = steady + (y - begin) * np.exp(-dt[i] / constant)
        previous = x[i]
        out[i] = y
    return y


@numba.njit(cache=True)
def limited_along(area: FloatArray, out: FloatArray, z: float, limit: float) -> float:
    """Fill ``out`` (n,) with a sum of ``area`` (n,) that stops at ``limit`` to either side, from z; z at the end."""
    for i in range(area.size):
        z = min(max(z + area[i], -limit), limit)
        out[i] = z
    return z


@numba.njit(cache=True)
def worked(y: float, moves: float, dt: float, rest: float, motion: float) -> float:
    """The state that motion works up and rest restores, after ``dt`` s in which something moves (1) or stands (0)."""
    if moves > 0.5:
        return float(1.0 + (y - 1.0) * np.exp(-dt / motion))
    return float(y * np.exp(-dt / rest))


@numba.njit(cache=True)
def worked_along(
    x: FloatArray,
    moved: FloatArray,
    before: FloatArray,
    own: FloatArray,
    out: FloatArray,
    y: float,
    rest: float,
    motion: float,
) -> float:
    """Fill ``out`` (n,) with the state that motion works up along x (1 where something moves), from y; y at the end.

    To a row it goes ``before`` (n,) s as ``moved`` (n,) says, then its ``own`` (n,) s as x does.
    """
    for i in range(x.size):
        y = worked(worked(y, moved[i], before[i], rest, motion), x[i], own[i], rest, motion)
        out[i] = y
    return y


class Memory:
    """States of a frame's terms that go on in the next frame: a row each, in the order in which the terms ask for them.

    A bench that runs has no recordings: what happens between two of them happens to the states as well. The first row
    of a frame is a copy of the second, at which the states begin if they have not: it is passed over.
    """

    def __init__(self) -> None:
        self.states = np.full((0, 2), np.nan)
        """of each: the state, and the input it last saw; NaN before it has seen any"""
        self._asked = 0

    def begin(self) -> None:
        """Begin with the first state again: the next frame's terms ask in the same order."""
        self._asked = 0

    def relaxing(self, x: FloatArray, forgotten: FloatArray, height: FloatArray, scale: float) -> FloatArray:
        """The relaxing state along x (n,), as it goes on; ``forgotten`` (n,) rate of forgetting times the time since
        the row before, ``height`` (n,) how far it relaxes.
        """
        states, out = self._next(), np.empty(x.size)
        if np.isnan(states[0]):
            states[:] = 0.0, x[0]
        out[0] = states[0]
        states[:] = relax_along(x[1:], forgotten[1:], height[1:], out[1:], states[0], states[1], scale)
        return out

    def play(self, x: FloatArray, half_width: float) -> FloatArray:
        """The play along x (n,), as it goes on."""
        states, out = self._next(), np.empty(x.size)
        states[:] = play_along(x, out, 0.0 if np.isnan(states[0]) else states[0], half_width), x[-1]
        return out

    def first(self, x: FloatArray) -> float:
        """The first value that x (n,) ever had."""
        states = self._next()
        if np.isnan(states[0]):
            states[:] = x[0]
        return float(states[0])

    def campaign_lag(self, x: FloatArray, dt: FloatArray, constant: float) -> FloatArray:
        """The lag of x (n,) as it goes on; ``dt`` (n,) s between rows."""
        states, out = self._next(), np.empty(x.size)
        if np.isnan(states[0]):
            states[:] = x[0]
        out[0] = states[0]
        states[:] = lag_along(x[1:], dt[1:], out[1:], states[0], states[1], constant), x[-1]
        return out

    def limited_integral(self, x: FloatArray, dt: FloatArray, limit: float) -> FloatArray:
        """The integral of x (n,) between its stops as it goes on; ``dt`` (n,) s between rows."""
        states, out = self._next(), np.empty(x.size)
        if np.isnan(states[0]):
            states[:] = 0.0, x[0]
        before = np.concatenate((states[1:], x[1:-1]))
        out[0] = states[0]
        states[:] = limited_along(0.5 * (x[1:] + before) * dt[1:], out[1:], states[0], limit), x[-1]
        return out

    def worked(self, x: FloatArray, dt: FloatArray, rest: float, motion: float) -> FloatArray:
        """The state that motion works up as it goes on; ``dt`` (n,) s between rows."""
        states, out = self._next(), np.empty(x.size)
        if np.isnan(states[0]):
            states[:] = 0.0, x[0]
        moved = np.concatenate((states[1:], x[1:-1]))
        out[0], half = states[0], 0.5 * dt[1:]
        states[:] = worked_along(x[1:], moved, half, half, out[1:], states[0], rest, motion), x[-1]
        return out

    def _next(self) -> FloatArray:
        if self._asked == len(self.states):
            self.states = np.vstack([self.states, np.full((1, 2), np.nan)])
        self._asked += 1
        return np.asarray(self.states[self._asked - 1])
