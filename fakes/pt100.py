"""PT100 conversion as a terminal or transmitter does it: resistance of the element, wiring, range, presentation.

Source: IEC 60751:2022 §5.2 (Callendar-Van Dusen). Written apart from the drivers' conversion, which goes the other way.
"""

from __future__ import annotations

import math
from enum import Enum

import numpy as np
import numpy.typing as npt

_A, _B, _C = 3.9083e-3, -5.775e-7, -4.183e-12
R0 = 100.0
LOW_C, HIGH_C = -200.0, 850.0


class Wiring(Enum):
    """State of the wires to the element."""

    GOOD = "good"
    OPEN = "open"
    SHORT = "short"


def wiring_of(celsius: float) -> Wiring:
    """Return the wiring a plant's reading stands for: far outside any temperature it says open (+) or short (-)."""
    if celsius > 2.0 * HIGH_C:
        return Wiring.OPEN
    return Wiring.SHORT if celsius < 2.0 * LOW_C else Wiring.GOOD


def resistance(celsius: float) -> float:
    """Return R(t) of a PT100 in Ω for t in °C."""
    base = 1.0 + _A * celsius + _B * celsius**2
    if celsius < 0.0:
        base += _C * (celsius - 100.0) * celsius**3
    return R0 * base


def measured_resistance(celsius: float, wiring: Wiring) -> float:
    """Return what the input sees in Ω: the element, an open circuit (infinite) or a short (zero)."""
    if wiring is Wiring.GOOD:
        return resistance(celsius)
    return math.inf if wiring is Wiring.OPEN else 0.0


TEMPERATURE, OHM_16, OHM_64 = 0, 8, 9
ELEMENTS: dict[int, float] = {TEMPERATURE: 0.0, OHM_16: 16.0, OHM_64: 64.0}
"""0x8000:19: temperature of a PT100, or resistance in so many counts an ohm."""

PRESENTATIONS: dict[int, float] = {0: 10.0, 2: 100.0}
"""0x8000:02: counts a kelvin."""

_UNDER, _OVER, _ERROR = 0x0001, 0x0002, 0x0040


def convert(celsius: npt.NDArray[np.float64], element: int, presentation: int) -> npt.NDArray[np.int64]:
    """Return rows of (status bits, INT value), one a conversion; open and short are out of range and an error."""
    if element == TEMPERATURE:
        scale = PRESENTATIONS.get(presentation, PRESENTATIONS[0])
        low, high = LOW_C, HIGH_C
        value = celsius
    else:
        scale = ELEMENTS.get(element, ELEMENTS[OHM_16])
        low, high = 10.0, min(1200.0, 32767.0 / scale)
        value = np.array([measured_resistance(t, wiring_of(t)) for t in celsius.tolist()])
    rows = np.empty((len(value), 2), dtype=np.int64)
    rows[:, 0] = (value > high) * (_OVER | _ERROR) + (value < low) * (_UNDER | _ERROR)
    counts = np.rint(np.minimum(np.maximum(value, low), high) * scale)
    rows[:, 1] = np.minimum(np.maximum(counts, -32768.0), 32767.0)
    return rows
