"""Smoothing of signals: rates from a local polynomial, wild samples found against a running median."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from bench.simulation.frame import FloatArray

SMOOTHING_S = 0.06
"""Window of the local polynomial: the shortest that leaves the 13-bit encoder's speed at a few mrad/s of noise."""
FINE_SMOOTHING_S = (0.015, 0.03)
"""windows for encoders so fine that the speed's noise stays below ``FINE_NOISE`` of the speed of standstill"""
FINE_NOISE = 2e-3
SPIKE_SIGMA = 9.0
ENOUGH_SAMPLES = 1 << 16


def window(rate: float, span: float = SMOOTHING_S) -> int:
    """Samples in a window of ``span`` s at a sample rate in Hz, odd."""
    return max(5, round(span * rate) // 2 * 2 + 1)


def span_for(angle: FloatArray, rate: float, standstill: float) -> float:
    """Window in s for rates of an angle: the shortest whose noise hides nothing as slow as ``standstill`` (rad/s).

    The angle's noise is read from its third differences, whose variance is 20 times its own.
    """
    if angle.size < 100:
        return SMOOTHING_S
    sigma = float(np.std(np.diff(angle, 3))) / np.sqrt(20.0)
    for span in FINE_SMOOTHING_S:
        width = window(rate, span)
        if sigma * rate * np.sqrt(12.0 / width**3) < FINE_NOISE * standstill:
            return span
    return SMOOTHING_S


def smooth(signal: FloatArray, rate: float, derivative: int = 0, span: float = SMOOTHING_S) -> FloatArray:
    """The signal, or a derivative of it in time, smoothed by the local polynomial over ``span`` s."""
    width = min(window(rate, span), (signal.size - 1) // 2 * 2 + 1)
    if width < 5:
        return np.gradient(signal) * rate if derivative else signal
    return np.asarray(
        savgol_filter(signal, width, 2, deriv=derivative, delta=1.0 / rate, mode="interp"), dtype=np.float64
    )


def spikes(signal: FloatArray) -> NDArray[np.bool_]:
    """Mark samples (at most two in a row) that stand off a running median by more than nine standard deviations."""
    if signal.size < 16 or not np.isfinite(signal).any():
        return ~np.isfinite(signal)
    bad = ~np.isfinite(signal)
    off = _off_median(np.where(bad, np.nanmedian(signal), signal) if bad.any() else signal)
    # the usual size of it needs no more than some ten thousand samples of a long recording
    told = off[:: max(1, off.size // ENOUGH_SAMPLES)]
    above = told[told > 0]
    scale = 1.4826 * np.median(above) if above.size else 0.0
    spread = max(scale, float(np.percentile(told, 95)) / 2.0, 1e-300)
    return np.asarray((off > SPIKE_SIGMA * spread) | bad)


@numba.njit(cache=True)
def _off_median(x: FloatArray) -> FloatArray:
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


def repaired(signal: FloatArray, bad: NDArray[np.bool_]) -> FloatArray:
    """The signal with its bad samples bridged by straight lines; 0 where all are bad."""
    if not bad.any():
        return signal
    if bad.all():
        return np.zeros_like(signal)
    index = np.arange(signal.size)
    return np.asarray(np.interp(index, index[~bad], signal[~bad]))
