"""What a mode swings by of its own after the speed has changed, beside its steady response to the orders.

A resonance multiplies the orders' amplitudes by its response at their frequency: that is the steady state. When the
speed changes, deflection and rate of the mode go on continuously, so that the difference between the steady states
before and after swings freely and decays (Thomson and Dahleh, Theory of Vibration with Applications, 1998, ch. 4).
Speed and amplitudes are taken as constant within a row, and what swings freely is carried from row to row exactly.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numba
import numpy as np
from numpy.typing import NDArray

from bench.simulation.frame import FloatArray, Frame, recording_starts
from bench.simulation.laws import EACH, MODES, Law, strengths

Complex = NDArray[np.complex128]
_LATE = 1.5
"""of what a row lasts, from which the time to the next is a gap: after it nothing is known of the mode"""


def free_oscillation(law: Law, frame: Frame, orders: FloatArray, vectors: Callable[[Frame], Complex]) -> FloatArray:
    """Mean of the free oscillation of a mode that swings (:attr:`Law.swings`) over each row of a frame (n,), rad.

    ``vectors`` (n, k): b + j·a of the ``orders`` (k,) that the mode answers, a·cos(f·θ) + b·sin(f·θ), at the rows of a
    frame, without the law. A recording begins in the steady state of its first row.
    """
    natural, damping, *share = law.point
    pole = natural * complex(-damping, np.sqrt(max(1.0 - damping**2, 1e-9)))
    touched = np.flatnonzero(np.isin(orders, np.asarray(law.orders)))
    out = np.zeros(frame.size)
    for a, b in itertools.pairwise(recording_starts(frame)):
        part = frame.take(slice(int(a), int(b)))
        if part.size < 2 or not touched.size:
            continue
        moved = vectors(part)[:, touched]
        if law.form in EACH:
            moved = moved * strengths(law, orders[touched].tolist())
        jumps = _jumps(part, orders[touched], moved, law, pole)
        out[a:b] = _carried(jumps, part.step, pole)
    return (share[0] if share else 1.0) * out


def over_angle(values: FloatArray, frame: Frame) -> FloatArray:
    """Change with the input angle of what takes ``values`` (n,) at the rows of a frame (n,); 0 at rest."""
    out = np.zeros(frame.size)
    for a, b in itertools.pairwise(recording_starts(frame)):
        if b - a > 1:
            rate = np.gradient(values[a:b], frame.elapsed[a:b])
            moving = frame.direction[a:b] != 0
            out[a:b][moving] = rate[moving] / frame.velocity[a:b][moving]
    return out


def _jumps(frame: Frame, orders: FloatArray, vectors: Complex, law: Law, pole: complex) -> Complex:
    """Complex deflection (n,) by which the free oscillation changes at the begin of each row."""
    form, natural, damping = law.form, law.point[0], law.point[1]
    speed, step = frame.velocity, frame.step
    # force or base: what moves goes on with its place and its rate
    steady = vectors * (1.0 + (MODES | EACH)[form](speed[:, None] * orders[None, :], natural, damping))
    both = np.maximum(step[:-1] + step[1:], 1e-300)
    angle = frame.theta[:-1] + np.diff(frame.theta) * step[:-1] / both
    deflection, velocity = _steps(steady, np.ascontiguousarray(speed), angle, np.ascontiguousarray(orders))
    out = np.zeros(frame.size, dtype=np.complex128)
    out[1:] = deflection - 1j * (velocity - pole.real * deflection) / pole.imag
    late = np.diff(frame.elapsed) > _LATE * 0.5 * both
    out[1:][late] = np.nan
    return out


@numba.njit(cache=True)
def _steps(steady: Complex, speed: FloatArray, angle: FloatArray, orders: FloatArray) -> tuple[FloatArray, FloatArray]:
    """By how much the ``steady`` response (n, k) of all orders, and its rate, fall short of the row before at the
    ``angle`` (n - 1,) between each two rows.
    """
    deflection, velocity = np.zeros(angle.size), np.zeros(angle.size)
    for i in range(angle.size):
        for k in range(orders.size):
            before, after = steady[i, k], steady[i + 1, k]
            if before == 0.0 and after == 0.0:
                continue
            wave = complex(np.cos(angle[i] * orders[k]), np.sin(angle[i] * orders[k]))
            change = (before * speed[i] - after * speed[i + 1]) * complex(0.0, orders[k])
            deflection[i] += ((before - after) * wave).imag
            velocity[i] += (change * wave).imag
    return deflection, velocity


@numba.njit(cache=True)
def _carried(jumps: Complex, step: FloatArray, pole: complex) -> FloatArray:
    """Mean over each row (n,) of what swings freely; a jump that is not a number ends it."""
    out = np.zeros(step.size)
    now = 0.0 + 0.0j
    for i in range(step.size):
        if i > 0:
            now = now * np.exp(pole * step[i - 1]) + jumps[i]
        if np.isnan(now.real):
            now = 0.0 + 0.0j
        x = pole * step[i]
        out[i] = (now * (np.exp(x) - 1.0) / x).real if abs(x) > 1e-9 else now.real
    return out
