"""Smoothing of signals: rates from a local polynomial, wild samples found against a running median."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.signal import savgol_filter

from bench.simulation.frame import FloatArray

SMOOTHING_S = 0.06
"""Window of the local polynomial: the shortest that leaves the 13-bit encoder's speed at a few mrad/s of noise."""
FINE_SMOOTHING_S = (0.015, 0.03)
"""windows for encoders so fine that the speed's noise stays below ``FINE_NOISE`` of the speed of standstill"""
FINE_NOISE = 2e-3
SPIKE_SIGMA = 9.0


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
    finite = np.where(np.isfinite(signal), signal, np.nanmedian(signal))
    off = np.abs(finite - median_filter(finite, 5, mode="nearest"))
    scale = 1.4826 * np.median(off[off > 0]) if np.any(off > 0) else 0.0
    spread = max(scale, float(np.percentile(off, 95)) / 2.0, 1e-300)
    return np.asarray((off > SPIKE_SIGMA * spread) | ~np.isfinite(signal))


def repaired(signal: FloatArray, bad: NDArray[np.bool_]) -> FloatArray:
    """The signal with its bad samples bridged by straight lines; 0 where all are bad."""
    if not bad.any():
        return signal
    if bad.all():
        return np.zeros_like(signal)
    index = np.arange(signal.size)
    return np.asarray(np.interp(index, index[~bad], signal[~bad]))
