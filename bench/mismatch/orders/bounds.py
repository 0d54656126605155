"""Where the angles are compared: at which speeds, and up to which acceleration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.simulation.frame import Frame

SLOWEST, FASTEST = 0.2, 1.1
"""of the slowest and the fastest steady revolution: within, the polynomials hold, and slow passages show a film or a
play best; not so the moments about standstill, nor the speed at which the bench warms up
"""


@dataclass(frozen=True, slots=True)
class Bounds:
    """Where the transmission error is compared: |velocity| in rad/s, and its largest change, rad/s².

    The simulation of the angles knows no dynamics: nothing is said of moments of strong acceleration.
    """

    slowest: float
    fastest: float
    acceleration: float

    @classmethod
    def of(cls, velocities: Sequence[float]) -> Bounds | None:
        """From the velocities of the steady revolutions; None where there are none."""
        if not velocities:
            return None
        top = max(abs(v) for v in velocities)
        low = SLOWEST * min(abs(v) for v in velocities)
        return cls(low, FASTEST * top, criteria.STRONG_ACCELERATION * top)

    def inside(self, frame: Frame) -> NDArray[np.bool_]:
        """Which rows of a frame are inside."""
        speed = np.abs(frame.velocity)
        change = np.abs(frame.acceleration) / frame.ratio
        return np.asarray((speed > self.slowest) & (speed < self.fastest) & (change < self.acceleration))
