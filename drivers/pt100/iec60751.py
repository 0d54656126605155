"""Platinum resistance thermometers by IEC 60751:2022 (Callendar–Van Dusen), both ways and vectorised.

For t in °C: R = R₀·(1 + A·t + B·t²) from 0 to 850 °C, and R = R₀·(1 + A·t + B·t² + C·(t − 100)·t³) from −200 to 0 °C.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

A = 3.9083e-3
B = -5.775e-7
C = -4.183e-12
"""Coefficients of the standard, 1/°C, 1/°C² and 1/°C⁴."""

LOWEST_C, HIGHEST_C = -200.0, 850.0
"""Range in which the standard defines the characteristic, °C."""


def resistance(temperature_c: ArrayLike, r0: float = 100.0) -> NDArray[np.float64]:
    """Resistance (…), Ω, at temperatures (…), °C; NaN outside the range of the standard.

    Examples
    --------
    >>> float(resistance(100.0))
    138.5055
    """
    t = np.asarray(temperature_c, np.float64)
    ratio = 1.0 + t * (A + t * B) + np.where(t < 0.0, C * (t - 100.0) * t**3, 0.0)
    return np.where((t >= LOWEST_C) & (t <= HIGHEST_C), r0 * ratio, np.nan)


def temperature(resistance_ohm: ArrayLike, r0: float = 100.0) -> NDArray[np.float64]:
    """Temperature (…), °C, of resistances (…), Ω; NaN outside the range of the standard: no sensor, or a broken one.

    Above 0 °C the quadratic is solved in closed form. Below, Newton's method starts from that solution; four steps
    reach rounding errors everywhere down to −200 °C.
    """
    ratio = np.asarray(resistance_ohm, np.float64) / r0
    with np.errstate(invalid="ignore"):
        root = np.sqrt(A * A - 4.0 * B * (1.0 - ratio))
        t = (root - A) / (2.0 * B)
        below = np.minimum(t, 0.0)
        for _ in range(4):
            cube = below**3
            error = 1.0 + below * (A + below * B) + C * (below - 100.0) * cube - ratio
            slope = A + 2.0 * B * below + C * (4.0 * cube - 300.0 * below**2)
            below = np.minimum(below - error / slope, 0.0)
        t = np.where(ratio < 1.0, below, t)
        lowest, highest = resistance(LOWEST_C) / 100.0, resistance(HIGHEST_C) / 100.0
        inside = (ratio >= lowest) & (ratio <= highest)
    return np.where(inside, t, np.nan)
