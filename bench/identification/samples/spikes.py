"""Single wild samples of a channel."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SIGMA = 9.0
"""standard deviations of the difference to a running median from which a sample is wild; chance: 1 in 1e18"""
LONGEST_RUN = 8
"""samples of a disturbance that are wild together: a shaft's torque takes longer"""
NEARLY_ALL = 99.0
"""percent of the samples whose reach is the range of a channel"""
FAR = 3.0
"""times that range from its middle, beyond which nothing measured lies for moments"""
LEAST_SAMPLES = 500
"""samples from which a range is told"""
ENOUGH_SAMPLES = 1 << 13
"""samples from which the usual size of a deviation is read: more of a long recording say no more"""


def spikes(signal: FloatArray, floor: float = 0.0) -> NDArray[np.bool_]:
    """Mark samples that are no number or (at most two in a row) stand far off a running median of five; and short runs
    at the end of a range, far out of that of all others.

    ``floor`` is the least standard deviation of what they stand off, in the signal's unit: quantisation is no spike.
    """
    bad = ~np.isfinite(signal)
    if signal.size < 16 or bad.all():
        return bad
    off = off_median(np.where(bad, np.nanmedian(signal), signal) if bad.any() else signal)
    sample = off[:: max(1, off.size // ENOUGH_SAMPLES)]
    above = sample[sample > 0]
    scale = 1.4826 * float(np.median(above)) if above.size else 0.0
    spread = max(scale, 0.5 * float(np.percentile(sample, 95)), floor, 1e-300)
    return np.asarray((off > SIGMA * spread) | bad | _out_of_range(signal, bad, SIGMA * spread))


def _out_of_range(signal: FloatArray, bad: NDArray[np.bool_], least: float) -> NDArray[np.bool_]:
    """Short runs of one and the same value (n,), by more than ``least`` and far beyond all others: the end of an
    amplifier's range. What a machine does in moments has no flat top.
    """
    step = max(1, signal.size // ENOUGH_SAMPLES)
    good = signal[::step][~bad[::step]]
    out = np.zeros(signal.size, dtype=bool)
    if good.size < LEAST_SAMPLES:
        return out
    middle = float(np.median(good))
    changes = np.abs(np.diff(good))
    quantum = float(changes[changes > 0.0].min()) if changes.any() else 0.0
    half_range = max(float(np.percentile(np.abs(good - middle), NEARLY_ALL)), quantum)
    with np.errstate(invalid="ignore"):
        far = np.abs(signal - middle) > max(FAR * half_range, half_range + least)
    if not far.any() or float(far.mean()) > 1.0 - NEARLY_ALL / 100.0:
        return out
    edges = np.flatnonzero(np.diff(np.concatenate(([0], far.astype(np.int8), [0])))).reshape(-1, 2)
    for a, b in edges[np.diff(edges, axis=1)[:, 0] <= LONGEST_RUN].tolist():
        out[a:b] = np.ptp(signal[a:b]) == 0.0
    return out


@njit(cache=True)
def off_median(x: FloatArray) -> FloatArray:
    """How far each sample is from the median of itself and its two neighbours on either side."""
    n = x.size
    out = np.empty(n)
    for i in range(n):
        a, b = x[max(i - 2, 0)], x[max(i - 1, 0)]
        c = x[i]
        d, e = x[min(i + 1, n - 1)], x[min(i + 2, n - 1)]
        # the median of five is that of e and what is left of the other four without their least and largest
        low, high = max(min(a, b), min(c, d)), min(max(a, b), max(c, d))
        out[i] = abs(c - max(min(low, high), min(max(low, high), e)))
    return out
