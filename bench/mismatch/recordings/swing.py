"""How fast the load torque of a recording changes, waves that are averaged out of the rows of a block included.

A delay of the torque channel adds in proportion to that rate. The rate of noise grows with the frequency without end,
so the level of white noise is taken off the spectrum first.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import welch

from bench.mismatch.recordings.prepared import Prepared
from bench.mismatch.recordings.vibration import NYQUIST_SHARE
from bench.simulation.terms import LOAD_TORQUE

SEGMENT_S = 2.0
"""segments that are averaged: a line of two hertz is told by 2 % too fast, the faster the less"""
WHITE = 0.5
"""of the frequencies, the highest, whose median is the level of white noise: lines are in a few of them"""
MEDIAN_OF_POWER = float(np.log(2.0))
"""median over mean of the power of noise in one segment, exponentially distributed"""


def swing(prepared: Prepared) -> float:
    """Mean square of the rate of the load torque in motion, (N·m/s)²; 0 where no run in motion lasts a segment."""
    frame, measured = prepared.frame, prepared.measured[LOAD_TORQUE]
    size = round(SEGMENT_S * prepared.sample_rate)
    moving = (frame.direction != 0) & (measured.number > 0)
    edges = np.flatnonzero(np.diff(moving.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    runs = [slice(a, b) for a, b in edges.tolist() if b - a >= max(size, 8)]
    if not runs:
        return 0.0
    squares = samples = 0.0
    for run in runs:
        found = welch(measured.mean[run], prepared.sample_rate, nperseg=size, detrend="constant")
        frequency, power = (np.asarray(part, dtype=np.float64) for part in found)
        inside = frequency < NYQUIST_SHARE * prepared.sample_rate
        frequency, power = frequency[inside], power[inside]
        high = power[int((1.0 - WHITE) * power.size) :]
        averaged = max(1.0, 2.0 * (run.stop - run.start) / size - 1.0)
        white = float(np.median(high)) / (MEDIAN_OF_POWER if averaged < 2.0 else 1.0)
        rate = float(np.sum((power - white) * (2.0 * np.pi * frequency) ** 2)) * float(frequency[1])
        squares += max(rate, 0.0) * (run.stop - run.start)
        samples += run.stop - run.start
    return squares / samples
