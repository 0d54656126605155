"""Where a resonance still rings: its law is that of steady motion and not of what a change of speed excites."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.orders.series import Series
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.laws import Law

_ALL_STEADY = 0.99
"""share of a row's samples in steady motion"""


def rings_for(laws: Sequence[Law], series: Series, noise: float) -> float:
    """Seconds (0 without a resonance) in which what a mode swings by has died away to the ``noise`` of a row, rad."""
    size = float(np.sqrt(sum(float(np.sum(amplitude[:, -1] ** 2)) for amplitude in series.amplitude.values())))
    out = 0.0
    for law in laws:
        if law.swings:
            natural, damping, *share = law.point
            swing = (share[0] if share else 1.0) * size / max(noise, 1e-300)
            out = max(out, float(np.log(max(swing, 1.0))) / (natural * damping))
    return out


def ringing(frame: Frame, seconds: float) -> NDArray[np.bool_]:
    """Rows (n,) in unsteady motion, or less than some ``seconds`` after it or after a change of direction: a segment
    that is called steady may hold a reversal.
    """
    if not seconds:
        return np.zeros(frame.size, dtype=bool)
    reversed_there = np.append(False, (np.diff(frame.recording) == 0) & (np.diff(frame.last_direction) != 0.0))
    unsteady = (frame.steady <= _ALL_STEADY) | reversed_there
    last: FloatArray = np.where(unsteady, frame.elapsed, -np.inf)
    for rows in np.split(np.arange(frame.size), np.flatnonzero(np.diff(frame.recording)) + 1):
        last[rows] = np.maximum.accumulate(last[rows])
    return np.asarray(frame.elapsed - last < max(seconds, 1e-9))
