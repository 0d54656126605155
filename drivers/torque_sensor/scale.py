"""From counts of the analogue terminal to torque."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, slots=True)
class TorqueScale:
    """Measuring chain of an analogue torque sensor.

    Attributes
    ----------
    volt_per_count : of the terminal, V.
    newton_metre_per_volt : of the sensor: rated torque over rated voltage, N·m/V.
    polarity : +1 where a positive voltage is a positive torque of the bench, else −1.
    zero_count : reading without torque (taring), counts.
    """

    volt_per_count: float
    newton_metre_per_volt: float
    polarity: int = 1
    zero_count: float = 0.0

    @property
    def newton_metre_per_count(self) -> float:
        """Signed scale of a count, N·m."""
        return self.polarity * self.volt_per_count * self.newton_metre_per_volt

    @property
    def offset_nm(self) -> float:
        """Torque of a reading of 0 counts, N·m."""
        return -self.zero_count * self.newton_metre_per_count

    def torque(self, counts: ArrayLike) -> NDArray[np.float64]:
        """Torque (n,), N·m, of counts (n,)."""
        return np.asarray(counts, np.float64) * self.newton_metre_per_count + self.offset_nm
