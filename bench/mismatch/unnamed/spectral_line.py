"""Frequency and amplitude of a line that lies somewhere between the frequencies of a spectrum with a Hann window.

A line at an offset of d bins has the amplitude W(d) = sinc(d) / (1 - d²) at the bin: up to 15 % less than at a bin.
The two bins beside tell d, and the three together hold its power (Harris, Proc. IEEE 66 (1978) 51).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm
from scipy.stats import t as student

from bench.simulation.frame import FloatArray

SURROGATES = 200
"""draws of the recordings with replacement"""
FEWEST = 3
"""recordings in which all three bins are seen, for the offset to be told from them"""
UPPER = 0.975
"""upper end of a two-sided interval of 95 %"""
BINS = np.arange(-1, 2)
"""the bin of the maximum and those beside it"""
NOISE_BANDWIDTH = 1.5
"""bins whose noise a Hann window lets pass"""


@dataclass(frozen=True, slots=True)
class SpectralLine:
    """Offset from the bin in bins, amplitude, their standard deviations over draws of the recordings, and the mean
    square in each recording (n,).
    """

    offset: float
    offset_std: float
    amplitude: float
    amplitude_std: float
    squares: FloatArray


def measured(excess: FloatArray, step: float, seed: int) -> SpectralLine:
    """A line from power densities (n, 3) beyond the noise, at the maximum and beside it, in bins of ``step`` Hz.

    NaN where a recording's is covered by something else; some have the middle. Where too few have all three, the line
    may be anywhere in its bin, and the standard deviations hold that.
    """
    known = np.asarray(np.isfinite(excess).all(axis=1))
    beside = bool(np.count_nonzero(known) >= FEWEST)
    rng = np.random.default_rng([seed, 8])
    offset, squares = _line(excess, known, step, None if beside else 0.0)
    again = []
    for _ in range(SURROGATES):
        rows = rng.integers(excess.shape[0], size=excess.shape[0])
        some = None if beside and known[rows].any() else float(rng.uniform(-0.5, 0.5))
        if np.isfinite(excess[rows, 1]).any():
            drawn, size = _line(excess[rows], known[rows], step, some)
            again.append((drawn, np.sqrt(2.0 * np.median(size))))
    offset_std, amplitude_std = np.std(np.array(again), axis=0)
    if beside:
        offset_std *= _of_few(int(np.count_nonzero(known)))
    return SpectralLine(
        offset, float(offset_std), float(np.sqrt(2.0 * np.median(squares))), float(amplitude_std), squares
    )


def mean_square(excess: FloatArray, offset: float, step: float) -> FloatArray:
    """Mean squares (...) of a line at an ``offset`` with power densities (..., 3) beyond the noise."""
    return np.asarray(np.maximum(excess.sum(axis=-1), 0.0) * step * NOISE_BANDWIDTH / _response(offset).sum())


def _of_few(number: int) -> float:
    """What the standard deviation over draws of ``number`` recordings is multiplied by: draws with replacement have
    (n - 1) / n of the variance, and the interval of 95 % is Student's.
    """
    return float(np.sqrt(number / (number - 1.0)) * student.ppf(UPPER, number - 1) / norm.ppf(UPPER))


def _line(excess: FloatArray, known: NDArray[np.bool_], step: float, offset: float | None) -> tuple[float, FloatArray]:
    """Offset, by the bins of all recordings together if it is None, and mean squares (n,) of a line."""
    if offset is None:
        low, middle, high = np.sqrt(np.maximum(excess[known].sum(axis=0), 0.0))
        # (W(d - 1) - W(d + 1)) / W(d) = 6 d / (4 - d²)
        ratio = (high - low) / max(low, middle, high, 1e-300)
        offset = float(np.clip(4.0 * ratio / (np.sqrt(9.0 + 4.0 * ratio**2) + 3.0), -0.5, 0.5))
    by_middle = np.maximum(excess[:, 1], 0.0) * step * NOISE_BANDWIDTH / _response(offset)[1]
    squares = np.where(known, mean_square(excess, offset, step), by_middle)
    # a recording in which something covers the line has it as the others have
    return offset, np.where(np.isfinite(squares), squares, np.nanmedian(squares))


def _response(offset: float) -> FloatArray:
    """Power (3,) of a line of amplitude 1 at the bins about it, over that of one at the middle of a bin."""
    away = offset - BINS
    safe = np.where(np.abs(np.abs(away) - 1.0) < 1e-6, 0.0, away)
    return np.where(safe == away, np.sinc(safe) / (1.0 - safe**2), 0.5) ** 2
