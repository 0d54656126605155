"""How fast the load torque of a recording changes, waves that are averaged out of the rows of a block included.

A delay of the torque channel adds in proportion to that rate. The rate of noise grows with the frequency without end,
so only lines count that stand far above the spectrum about them, and only those too fast for the rows of a block.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.ndimage import median_filter
from scipy.signal import welch

from bench.mismatch.recordings.prepared import Prepared
from bench.mismatch.recordings.vibration import NYQUIST_SHARE
from bench.simulation.terms import LOAD_TORQUE

BoolArray = npt.NDArray[np.bool_]

SEGMENT_S = 2.0
"""segments that are averaged: a line of two hertz is told by 2 % too fast, the faster the less"""
ABOUT_HZ = 20.0
"""width of the spectrum about a line whose median is its level: much wider than a line, which a window spreads over
three bins of half a hertz"""
ABOVE = 25.0
"""times the level about it that a line has: the power of noise in a bin of one segment is exponentially distributed,
and above that once in e^-17 bins"""
SLOW_S = 0.1
"""as long as rows are at least: half a period of the slowest wave that they average out"""


def swing(prepared: Prepared) -> float:
    """Mean square of the rate of the load torque in motion, (N·m/s)², by waves that the rows of a block average out;
    0 where no run in motion lasts a segment, and where samples are as slow as rows: no wave is averaged out of these.
    """
    if NYQUIST_SHARE * prepared.sample_rate <= 0.5 / SLOW_S:
        return 0.0
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
        level = median_filter(power, size=max(3, round(ABOUT_HZ / frequency[1]) | 1), mode="nearest")
        lines = _widened(power > ABOVE * level, power > level) & (frequency > 0.5 / SLOW_S)
        rate = float(np.sum((power * (2.0 * np.pi * frequency) ** 2)[lines])) * float(frequency[1])
        squares += rate * (run.stop - run.start)
        samples += run.stop - run.start
    return squares / samples


def _widened(lines: BoolArray, about: BoolArray) -> BoolArray:
    """Lines and the bin on either side of each, where it stands above the level as well."""
    wide = lines.copy()
    wide[1:] |= lines[:-1]
    wide[:-1] |= lines[1:]
    return np.asarray(lines | (wide & about), dtype=np.bool_)
