"""Samples of a thermometer whose circuit is open or shorted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

PT100_RANGE = (-200.0, 850.0)
"""°C at which the range of a PT100 ends (IEC 60751): a terminal or transmitter reports it, or more, where the circuit
is shorted or open"""


def beyond_pt100(celsius: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Samples (n,) of a temperature in °C that no PT100 measures.

    A terminal whose stored integers end before 850 °C (327.67 °C, of hundredths in 16 bits) is not found so.
    """
    return np.asarray((celsius <= PT100_RANGE[0]) | (celsius >= PT100_RANGE[1]))
