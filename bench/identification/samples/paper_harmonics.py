"""Amplitude, phase and offset of one recording exactly as the paper prints them (ICIT 2025, section II-C).

Amplitudes: linear interpolation to equidistant θ, notch at the load motor's ripple, linear trend removed, Hamming
window, zero-padding to the next power of two above ten times the length, FFT, division by the window's sum,
single-sided.
Phases: atan2(a_k, b_k) of the Fourier integrals over one revolution. The paper prints their argument as
f_k·θ_TE(θ̄); that is a misprint for f_k·θ̄, the angle itself. Offset: the mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import filtfilt, iirnotch

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

NOTCH_WIDTH_ORDERS = 2.0
"""−3 dB width of each notch; the paper gives none."""
_BLOCK = 256


@dataclass(frozen=True, slots=True)
class Harmonics:
    """Of one recording: amplitude and phase (K,) in rad, offset in rad."""

    amplitude: FloatArray
    phase: FloatArray
    offset: float


def equidistant(theta: FloatArray, error: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Interpolate (θ, TE) linearly to as many equidistant angles, increasing whatever the direction of motion."""
    if theta[-1] < theta[0]:
        theta, error = theta[::-1], error[::-1]
    # A noisy encoder may step back by a count; interpolation needs angles that do not.
    rising = np.maximum.accumulate(theta)
    grid = np.linspace(rising[0], rising[-1], rising.size)
    return grid, np.interp(grid, rising, error)


def notch(error: FloatArray, step: float, orders: Sequence[float]) -> FloatArray:
    """Filter out ``orders`` with zero phase; ``step`` is the angle between samples in rad."""
    rate = 2.0 * np.pi / step
    for order in orders:
        if order < 0.45 * rate:
            b, a = iirnotch(order, order / NOTCH_WIDTH_ORDERS, fs=rate)
            error = filtfilt(b, a, error)
    return np.asarray(error)


def _detrended(values: FloatArray) -> FloatArray:
    """Values (N,) less their straight line of least squares."""
    position = np.arange(values.size) - 0.5 * (values.size - 1)
    slope = float(position @ values) / max(float(position @ position), 1e-300)
    return np.asarray(values - values.mean() - slope * position)


def padded_length(size: int) -> int:
    """Return the next power of two above ten times the length."""
    return int(2 ** np.ceil(np.log2(10 * size)))


def fourier_sums(x: FloatArray, rates: FloatArray) -> ComplexArray:
    """Σ_n x_n·exp(−i·rate·n) for each rate (K,), without a samples × rates matrix.

    The sum over n = 256·b + m splits into one over m, a product with a 256 × K matrix, and one over b.
    """
    blocks = -(-x.size // _BLOCK)
    padded = np.zeros(blocks * _BLOCK)
    padded[: x.size] = x
    inner = np.exp(-1j * np.outer(np.arange(_BLOCK), rates))
    rows = padded.reshape(blocks, _BLOCK)
    partial = rows @ inner.real + 1j * (rows @ inner.imag)
    outer = np.exp(-1j * np.outer(np.arange(blocks) * _BLOCK, rates))
    return np.asarray((partial * outer).sum(axis=0))


def padded_amplitudes(error: FloatArray, step: float, orders: Sequence[float]) -> FloatArray:
    """Single-sided amplitude (K,) at the bins nearest to ``orders`` of the windowed, zero-padded FFT.

    Only the bins asked for are summed: the same numbers as the whole FFT's, without its two million others.
    """
    window = np.hamming(error.size)
    weighted = _detrended(error) * window
    length = padded_length(error.size)
    total = window.sum()
    bins = np.rint(np.asarray(orders) * length * step / (2.0 * np.pi))
    return np.asarray(2.0 * np.abs(fourier_sums(weighted, 2.0 * np.pi * bins / length)) / total)


def padded_spectrum(error: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    """Orders and single-sided amplitudes of the whole windowed, zero-padded spectrum (for plots)."""
    window = np.hamming(error.size)
    length = padded_length(error.size)
    amplitude = 2.0 * np.abs(np.fft.rfft(_detrended(error) * window, length)) / window.sum()
    amplitude[0] *= 0.5
    return np.arange(amplitude.size) * (2.0 * np.pi / (length * step)), amplitude


def paper_harmonics(
    theta: FloatArray, error: FloatArray, orders: Sequence[float], notch_orders: Sequence[float]
) -> Harmonics:
    """Identify one recording's steady motion of at least a revolution; (N,) rad each."""
    grid, even = equidistant(theta, error)
    step = grid[1] - grid[0]
    even = notch(even, step, notch_orders)
    count = min(round(2.0 * np.pi / step), even.size)
    angle, once = grid[:count], even[:count]
    # ∫ TE·exp(−i·f·θ̄) dθ̄ / π over one revolution, θ̄ counted from the encoder's zero: a_k − i·b_k.
    frequencies = np.asarray(orders, dtype=np.float64)
    integral = fourier_sums(once, frequencies * step) * np.exp(-1j * frequencies * angle[0]) * step / np.pi
    phase = np.arctan2(integral.real, -integral.imag)
    return Harmonics(padded_amplitudes(even, step, orders), phase, float(error.mean()))
