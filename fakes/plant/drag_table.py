"""Friction over speed and temperature as a table, for laws that a simulation file brings."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

_TOP_SPEED = 800.0
"""rad/s at the motor shaft, end of the table"""
_SPEEDS = 401
_COLD, _WARM, _TEMPERATURES = -20.0, 130.0, 61


def speeds() -> NDArray[np.float64]:
    """Return the table's speeds (W,), dense where friction bends, near rest."""
    return np.asarray(_TOP_SPEED * np.linspace(0.0, 1.0, _SPEEDS) ** 2)


def temperatures() -> NDArray[np.float64]:
    """Return the table's temperatures (C,), °C."""
    return np.linspace(_COLD, _WARM, _TEMPERATURES)


@njit(cache=True, error_model="numpy")
def look_up(table: NDArray[np.float64], speed: float, temperature: float) -> float:
    """Interpolate the table (W, C) linearly in both; at its ends it goes on as constant."""
    x = min(math.sqrt(speed / _TOP_SPEED), 1.0) * (_SPEEDS - 1)
    i = min(int(x), _SPEEDS - 2)
    low = _TOP_SPEED * (i / (_SPEEDS - 1)) ** 2
    high = _TOP_SPEED * ((i + 1) / (_SPEEDS - 1)) ** 2
    a = min((speed - low) / (high - low), 1.0)
    y = min(max((temperature - _COLD) / (_WARM - _COLD), 0.0), 1.0) * (_TEMPERATURES - 1)
    k = min(int(y), _TEMPERATURES - 2)
    b = y - k
    cold = table[i, k] + a * (table[i + 1, k] - table[i, k])
    warm = table[i, k + 1] + a * (table[i + 1, k + 1] - table[i, k + 1])
    return float(cold + b * (warm - cold))
