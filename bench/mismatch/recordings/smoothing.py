"""Smoothing of signals: value and rates from a local quadratic; wild samples bridged."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.simulation.frame import FloatArray

WINDOWS_S = (0.015, 0.03, 0.06)
"""lengths of the window that are tried, the shortest first; the last is taken for a coarse encoder"""

SHORTEST = 5
"""samples of the shortest window: a parabola through fewer follows the noise"""
_AFRESH = 256
"""samples after which moving sums are made afresh"""


def window(rate: float, span: float) -> int:
    """Samples in a window of ``span`` s at a sample rate in Hz, odd, :data:`SHORTEST` at least."""
    return max(SHORTEST, round(span * rate) // 2 * 2 + 1)


def span_for(angle: FloatArray, rate: float, standstill: float) -> float:
    """Window in s for rates of an angle: the shortest whose noise hides nothing as slow as ``standstill`` (rad/s).

    The angle's noise is read from its third differences, whose variance is 20 times its own.
    """
    if angle.size < 100:
        return WINDOWS_S[-1]
    sigma = float(np.std(np.diff(angle, 3))) / np.sqrt(20.0)
    for span in WINDOWS_S[:-1]:
        width = window(rate, span)
        if sigma * rate * np.sqrt(12.0 / width**3) < criteria.SPEED_NOISE * standstill:
            return span
    return WINDOWS_S[-1]


def local_quadratic(signal: FloatArray, rate: float, span: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Value, first and second derivative in time of the quadratic fitted about each sample (Savitzky and Golay 1964).

    ``signal`` (n,) at ``rate`` Hz; the window lasts ``span`` s. At the ends the first and the last whole window's
    quadratic is evaluated.
    """
    n = signal.size
    width = min(window(rate, span), (n - 1) // 2 * 2 + 1)
    if width < 5:
        slope = np.gradient(signal) * rate if n > 1 else np.zeros(n)
        return signal.astype(np.float64), slope, np.zeros(n)
    value, slope, curve = _quadratic(np.ascontiguousarray(signal, dtype=np.float64), width // 2)
    return value, slope * rate, curve * rate**2


def passed_by(rate: float, span: float, hertz: FloatArray) -> FloatArray:
    """Share (n,) of a second derivative at frequencies (n,) in Hz that :func:`local_quadratic` lets pass."""
    return np.asarray(-_response(rate, span, hertz, 2) / (2.0 * np.pi * np.maximum(hertz, 1e-9)) ** 2)


def value_passed_by(rate: float, span: float, hertz: FloatArray) -> FloatArray:
    """Share (n,) of a value at frequencies (n,) in Hz that :func:`local_quadratic` lets pass."""
    return _response(rate, span, hertz, 0)


def _response(rate: float, span: float, hertz: FloatArray, derivative: int) -> FloatArray:
    """What the value (0) or the second derivative (2) is of a cosine of size one at frequencies (n,) in Hz."""
    half = window(rate, span) // 2
    impulse = np.zeros(4 * half + 1)
    impulse[2 * half] = 1.0
    weights = local_quadratic(impulse, rate, span)[derivative][half : 3 * half + 1]
    angle = 2.0 * np.pi * np.outer(hertz, np.arange(-half, half + 1)) / rate
    return np.asarray(np.cos(angle) @ weights)


@numba.njit(cache=True)
def _quadratic(y: FloatArray, m: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    n = y.size
    value, slope, curve = np.empty(n), np.empty(n), np.empty(n)
    count = 2 * m + 1
    s2 = 0.0
    s4 = 0.0
    for i in range(1, m + 1):
        s2 += 2.0 * i * i
        s4 += 2.0 * float(i) ** 4
    det = count * s4 - s2 * s2
    zero = a = b = d = 0.0
    for c in range(m, n - m):
        if (c - m) % _AFRESH == 0:  # sums about a centre nearby, so that rounding does not add up
            zero = y[c]
            a = b = d = 0.0
            for i in range(-m, m + 1):
                above = y[c + i] - zero
                a += above
                b += i * above
                d += i * i * above
        else:  # the window moves on by one sample
            gone, come = y[c - m - 1] - zero, y[c + m] - zero
            d += (m + 1) * (m + 1) * come - m * m * gone
            b += (m + 1) * come + m * gone
            a += come - gone
            d += a - 2.0 * b
            b -= a
        two = (count * d - s2 * a) / det
        value[c] = zero + (a - two * s2) / count
        slope[c] = b / s2
        curve[c] = 2.0 * two
    for end in range(2):
        c = m if end == 0 else n - 1 - m
        for i in range(1, m + 1):
            index = c - i if end == 0 else c + i
            x = float(index - c)
            value[index] = value[c] + slope[c] * x + 0.5 * curve[c] * x * x
            slope[index] = slope[c] + curve[c] * x
            curve[index] = curve[c]
    return value, slope, curve


def repaired(signal: FloatArray, bad: NDArray[np.bool_]) -> FloatArray:
    """The signal with its bad samples bridged by straight lines; 0 where all are bad."""
    if not bad.any():
        return signal
    if bad.all():
        return np.zeros_like(signal)
    index = np.arange(signal.size)
    return np.asarray(np.interp(index, index[~bad], signal[~bad]))
