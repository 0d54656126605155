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
