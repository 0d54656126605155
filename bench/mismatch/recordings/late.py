"""How late a sensor tells a ripple: with the right lag its phase, at every speed, is that of one angle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from bench.mismatch import criteria
from bench.simulation.frame import FloatArray

Complex = NDArray[np.complex128]

LONGEST_LAG_S = 0.1
"""that is looked for: fifty samples of a filter at 500 Hz; a later torque is seen by its level wherever the load moves
"""
STEP_RAD = 0.5
"""by which the fastest ripple turns from one lag that is tried to the next: a third of what halves a sum of vectors"""


def lags_tried(speed: FloatArray, orders: Sequence[float]) -> FloatArray:
    """Lags in s that are tried for ripple of some orders at speeds (recordings,) in rad/s; 0 is one of them."""
    fastest = float(np.abs(speed).max()) * max(orders)
    each_way = int(LONGEST_LAG_S * fastest / STEP_RAD)
    return np.arange(-each_way, each_way + 1, dtype=np.float64) * (STEP_RAD / max(fastest, 1e-300))


def lag_of(vectors: Complex, one: FloatArray, speed: FloatArray, orders: Sequence[float]) -> float:
    """Lag in s of one ripple in vectors (recordings, orders), in which 1 N·m is ``one`` (recordings,).

    0 where no lag makes the vectors of one ripple likelier by odds of twenty to one, after the number of lags that were
    tried. Speeds that are multiples of one another leave several that are as good: of those within the same odds the
    smallest is taken.
    """
    tried = lags_tried(speed, orders)
    if tried.size < 3:
        return 0.0
    freedom = vectors.size - vectors.shape[1]

    def cost(lag: float) -> float:
        return float(freedom * np.log(scatter(vectors, one, speed, orders, lag)))

    costs, near = np.array([cost(lag) for lag in tried.tolist()]), float(tried[1] - tried[0])
    lower = np.concatenate(([np.inf], costs[:-1])), np.concatenate((costs[1:], [np.inf]))
    minima = tried[(costs <= lower[0]) & (costs <= lower[1])]
    found = [
        minimize_scalar(cost, bounds=(lag - near, lag + near), method="bounded", options={"xatol": 1e-3 * near})
        for lag in minima.tolist()
    ]
    best = min(float(one.fun) for one in found)
    nearest = min((one for one in found if one.fun < best + criteria.RICHER), key=lambda one: abs(float(one.x)))
    gain = cost(0.0) - float(nearest.fun)
    return float(nearest.x) if gain > criteria.RICHER + float(np.log(tried.size)) else 0.0


def scatter(vectors: Complex, one: FloatArray, speed: FloatArray, orders: Sequence[float], lag: float) -> float:
    """Sum of squares that one ripple of each order, told late by a lag, leaves in vectors (recordings, orders)."""
    back = vectors * np.exp(-1j * lag * speed[:, None] * np.asarray(orders))
    ripple = one @ back / float(one @ one)
    return max(float(np.sum(np.abs(back - one[:, None] * ripple) ** 2)), 1e-300)
