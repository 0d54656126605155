"""How far and for how long the bench has moved in a run: what models ask for beside load, speed and temperature."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


class Covered:
    """Counts from the run's first motion on, a block of rows at a time; a block's turning back inside it is not seen.

    Times are in s of the bench, distances in rad at the output, named as in :class:`bench.simulation.frame.Frame`.
    """

    def __init__(self) -> None:
        self._first: float | None = None
        self._began = 0.0
        self._travel = 0.0
        self._last: float | None = None
        self._sign = 0.0
        self._turned_at = (0.0, 0.0)
        self._turned = 0.0

    def begin(self, now_s: float) -> None:
        """A motion begins at this time of the bench, s of any epoch."""
        self._first = now_s if self._first is None else self._first
        self._began = now_s
        self._last, self._sign, self._turned = None, 0.0, 0.0
        self._turned_at = (self._travel, now_s)

    def add(self, theta: NDArray[np.float64], end_s: float) -> dict[str, float]:
        """Take input angles in load-side scaling, rad, up to a time; return where the motion stands then."""
        if theta.size:
            step = float(theta[-1] - (theta[0] if self._last is None else self._last))
            sign = float(np.sign(step))
            if sign != 0.0:
                if self._sign not in (0.0, sign):
                    self._turned_at, self._turned = (self._travel, end_s), 1.0
                self._sign = sign
            self._travel += abs(step)
            self._last = float(theta[-1])
        return {
            "time": end_s - (end_s if self._first is None else self._first),
            "elapsed": end_s - self._began,
            "travel": self._travel,
            "reversal_travel": self._travel - self._turned_at[0],
            "reversal_time": end_s - self._turned_at[1],
            "reversed_before": self._turned,
        }
