"""Path-dependent elements, each advanced sample by sample.

The last entry of every ``state`` is the last drive, so that a path goes on from one recording to the next.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@njit(cache=True)
def maxwell_slip(drive: Floats, breaks: Floats, weights: Floats, state: Floats) -> Floats:
    """Sum of elasto-slide elements on ``drive`` (N,); ``state`` (K + 1,) is advanced in place."""
    out = np.empty(drive.size)
    last = state[-1]
    for n in range(drive.size):
        step = drive[n] - last
        last = drive[n]
        total = 0.0
        for k in range(breaks.size):
            z = state[k] + step
            if z > breaks[k]:
                z = breaks[k]
            elif z < -breaks[k]:
                z = -breaks[k]
            state[k] = z
            total += weights[k] * z / breaks[k]
        out[n] = total
    state[-1] = last
    return out


@njit(cache=True)
def bouc_wen(drive: Floats, scale: float, beta: float, power: float, state: Floats) -> Floats:
    """Bouc–Wen element of unit saturation: dz = dx/scale·(1 − |z|^n (β sgn(z dx) + 1 − β))."""
    out = np.empty(drive.size)
    last = state[-1]
    z = state[0]
    for n in range(drive.size):
        step = (drive[n] - last) / scale
        last = drive[n]
        pieces = 1 + int(abs(step) / 0.05)
        for _ in range(pieces):
            part = step / pieces
            z += part * (1.0 - abs(z) ** power * (beta * np.sign(z * part) + 1.0 - beta))
        out[n] = z
    state[0], state[-1] = z, last
    return out


@njit(cache=True)
def duhem(drive: Floats, scale: float, state: Floats) -> Floats:
    """Dahl's element as an exact exponential approach of ±1 along ``drive``."""
    out = np.empty(drive.size)
    last = state[-1]
    z = state[0]
    for n in range(drive.size):
        step = drive[n] - last
        last = drive[n]
        if step > 0.0:
            z = 1.0 + (z - 1.0) * np.exp(-step / scale)
        elif step < 0.0:
            z = -1.0 + (z + 1.0) * np.exp(step / scale)
        out[n] = z
    state[0], state[-1] = z, last
    return out


@njit(cache=True)
def play(drive: Floats, half: float, state: Floats) -> Floats:
    """Play operator of half width ``half``, minus its drive, over the half width: within ±1."""
    out = np.empty(drive.size)
    z = state[0]
    for n in range(drive.size):
        if z < drive[n] - half:
            z = drive[n] - half
        elif z > drive[n] + half:
            z = drive[n] + half
        out[n] = (drive[n] - z) / half
    state[0] = z
    return out


@njit(cache=True)
def lugre(rate: Floats, step: float, bristle: float, slow: float, excess: float, state: Floats) -> Floats:
    """LuGre bristle deflection over its steady one at high speed; ``bristle`` in rad, ``slow`` in rad/s."""
    out = np.empty(rate.size)
    z = state[0]
    for n in range(rate.size):
        level = 1.0 + excess * np.exp(-((rate[n] / slow) ** 2))
        gain = abs(rate[n]) / (bristle * level)
        target = np.sign(rate[n]) * level
        z = target + (z - target) * np.exp(-gain * step) if rate[n] != 0.0 else z
        out[n] = z
    state[0] = z
    return out


@njit(cache=True)
def follow(drive: Floats, keep: float, start: float) -> Floats:
    """First-order lag (N,) of ``drive`` from ``start`` on; ``keep`` is the share of the gap left after one step."""
    out = np.empty(drive.size)
    state = start
    for n in range(drive.size):
        state = drive[n] + (state - drive[n]) * keep if n > 0 else start
        out[n] = state
    return out


@njit(cache=True)
def structure(moving: Floats, step: float, breaking: float, healing: float, start: float) -> Floats:
    """Structure (N,) of a thixotropic grease, 0 to 1: it breaks down while it is sheared and heals at rest."""
    out = np.empty(moving.size)
    state = start
    down, up = np.exp(-step / breaking), np.exp(-step / healing)
    for n in range(moving.size):
        state = state * down if moving[n] != 0.0 else 1.0 - (1.0 - state) * up
        out[n] = state
    return out


@njit(cache=True)
def ringing(drive: Floats, moving: Floats, step: float, omega: float, decay: float, last: float) -> Floats:
    """Decaying oscillation (N,) of unit size struck whenever ``drive`` crosses zero in motion, up or down."""
    out = np.zeros(drive.size)
    x, v = 0.0, 0.0
    before = last
    for n in range(drive.size):
        if drive[n] * before < 0.0 and moving[n] != 0.0:
            v += omega if drive[n] > 0.0 else -omega
        if drive[n] != 0.0:
            before = drive[n]
        # exact step of the undamped oscillator, damped by its envelope
        c, s, fade = np.cos(omega * step), np.sin(omega * step), np.exp(-step / decay)
        x, v = fade * (c * x + s * v / omega), fade * (c * v - s * omega * x)
        out[n] = x
    return out
