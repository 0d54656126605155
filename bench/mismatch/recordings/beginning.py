"""The state a recording begins with: what its first seconds tell of it."""

from __future__ import annotations

import itertools

import numpy as np

from bench.simulation.frame import FloatArray, Frame, recording_starts

START_S = 15.0
"""first seconds of a recording that tell the temperature it begins with, s. Noise of a thermometer is correlated over
about a second: the mean of six seconds is wrong by 0.4 standard deviations, and the whole recording with it; that of a
quarter of a minute by 0.2. No balance of heat bends within that time
(:func:`bench.mismatch.regression.slow_noise.scattered`)
"""


def at_start(frame: Frame, values: FloatArray) -> FloatArray:
    """Means of ``values`` (n,) over the first seconds of each recording (recordings,)."""
    starts = recording_starts(frame)
    out = np.empty(starts.size - 1)
    for k, (a, b) in enumerate(itertools.pairwise(starts)):
        stop = a + max(1, int(np.searchsorted(frame.time[a:b], frame.time[a] + START_S)))
        out[k] = float(np.mean(values[a:stop]))
    return out


def risen(frame: Frame, level: FloatArray) -> FloatArray:
    """A number of each recording (recordings,) at all its rows (n,)."""
    return np.repeat(level, np.diff(recording_starts(frame)))
