"""A tone: a disturbance of one frequency over time, in recordings of whatever speed.

An order of the gearbox moves with the speed, a tone stands at its hertz. So the spectra are compared by speed: at each
frequency the median over the speeds of the power over the noise about it. What the largest such median is in noise is
drawn from the law of averaged periodograms.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bench.mismatch import criteria
from bench.mismatch.recordings.vibration import NYQUIST_SHARE, Density
from bench.mismatch.regression.maxima import tail_probability
from bench.mismatch.regression.noise import LOWEST_HZ
from bench.simulation.frame import FloatArray, IntArray

SPEEDS = 3
"""different speeds that must have been driven for a tone to be told from an order"""
ALIKE = 0.03
"""relative difference of speeds that count as one"""
SURROGATES = 200
MOST_FREQUENCIES = 400
"""that a surrogate has"""
_LEAK = 2
"""bins to either side of an order that its line reaches in a Hann window"""
_ABOUT = 41
"""frequencies whose median tells the noise at one"""


@dataclass(frozen=True, slots=True)
class Tone:
    """Frequency in Hz with half a bin as its range, amplitude and its standard deviation, chance in noise, the
    recordings by power, and the tone's mean square in each of them.
    """

    frequency: float
    half_bin: float
    amplitude: float
    amplitude_std: float
    p_value: float
    recordings: tuple[int, ...]
    squares: tuple[float, ...] = ()


def tone(densities: Sequence[Density], seed: int, orders: Sequence[float] = ()) -> Tone | None:
    """The clearest tone of a channel; None where the spectra cannot tell one from orders.

    Frequencies of ``orders`` known to be there are left out of each recording.
    """
    kinds = [(d.rate, d.power.size) for d in densities]
    if not kinds:
        return None
    usual = max(set(kinds), key=kinds.count)
    rate = usual[0]
    own = [d for d in densities if (d.rate, d.power.size) == usual]
    groups = _speeds(np.array([d.turning for d in own]))
    if groups.max(initial=-1) + 1 < SPEEDS:
        return None
    step = own[0].step
    first, last = int(np.ceil(LOWEST_HZ / step)), int(NYQUIST_SHARE * rate / step)
    power = np.array([d.power[first:last] for d in own], dtype=np.float64)
    # the median of an exponential variable is ln 2 of its mean; of averaged ones it comes nearer to the mean
    # row by row: of one dimension the filter is ten times as quick
    level = np.array([median_filter(row, _ABOUT, mode="nearest") for row in power])
    ratio = power / np.maximum(level, 1e-300)
    for k, density in enumerate(own):
        bins = np.round(np.asarray(orders, dtype=np.float64) * density.turning / step).astype(int) - first
        for off in range(-_LEAK, _LEAK + 1):
            near = bins + off
            ratio[k, near[(near >= 0) & (near < ratio.shape[1])]] = np.nan
    freedom = np.array([2.0 * d.averaged for d in own])
    statistic = _by_speed(ratio, groups)
    frequencies = min(ratio.shape[1], MOST_FREQUENCIES)
    looked = np.isfinite(ratio)
    if looked.all():
        largest = _largest(tuple(freedom.tolist()), tuple(groups.tolist()), frequencies, seed)
    else:
        # where orders cover most speeds, the few that are left scatter more
        largest = _drawn(freedom, groups, frequencies, seed, looked)
    if not np.isfinite(statistic).any():
        return None
    place = int(np.nanargmax(statistic))
    # surrogates of some frequencies stand for all: the maximum of m blocks
    blocks = max(ratio.shape[1] / MOST_FREQUENCIES, 1.0)
    p = float(np.clip(blocks * tail_probability(largest, float(statistic[place]), 0.0), criteria.LEAST_P, 1.0))
    excess = np.maximum(power[:, place] - level[:, place], 0.0)
    # power density of a tone in a Hann window: a²/2 over 1.5 bins
    squares = 2.0 * excess * 1.5 * step
    amplitude = float(np.sqrt(np.median(squares)))
    spread = float(np.std(np.sqrt(squares)) / np.sqrt(max(squares.size, 1)))
    strongest = np.argsort(-excess)
    return Tone(
        float((first + place) * step),
        0.5 * step,
        amplitude,
        spread,
        p,
        tuple(own[k].recording for k in strongest),
        tuple(float(0.5 * squares[k]) for k in strongest),
    )


@lru_cache(maxsize=4)
def _largest(freedom: tuple[float, ...], groups: tuple[int, ...], frequencies: int, seed: int) -> FloatArray:
    """The clearest tone in surrogates of noise (SURROGATES,), whose spectra have degrees of ``freedom`` and are of the
    speeds ``groups``. The channels of a folder mostly have both in common.
    """
    return _drawn(np.asarray(freedom), np.asarray(groups), frequencies, seed, None)


def _drawn(
    freedom: FloatArray, groups: IntArray, frequencies: int, seed: int, looked: NDArray[np.bool_] | None
) -> FloatArray:
    """The same where the spectra were ``looked`` at (recordings, all frequencies) in part (None: everywhere)."""
    rng = np.random.default_rng([seed, 7])
    out = np.empty(SURROGATES)
    for k in range(SURROGATES):
        drawn = rng.chisquare(freedom[:, None], size=(freedom.size, frequencies))
        drawn /= np.median(drawn, axis=1, keepdims=True)
        if looked is not None:
            drawn[~looked[:, rng.integers(looked.shape[1], size=frequencies)]] = np.nan
        out[k] = np.nanmax(_by_speed(drawn, groups), initial=0.0)
    return out


def _speeds(turning: FloatArray) -> IntArray:
    """Number of the speed that each recording was driven at."""
    order = np.argsort(turning)
    out = np.zeros(turning.size, dtype=np.int64)
    number = 0
    for before, here in itertools.pairwise(order):
        number += turning[here] > (1.0 + ALIKE) * turning[before] + 1e-9
        out[here] = number
    return out


def _by_speed(ratio: FloatArray, groups: IntArray) -> FloatArray:
    """Median over the speeds of the mean over the recordings of each speed; NaN where fewer than :data:`SPEEDS` have
    one: orders cover a frequency at some speeds.
    """
    own = (groups == np.arange(int(groups.max()) + 1)[:, None]).astype(np.float64)
    finite = np.isfinite(ratio)
    number = own @ finite
    means = np.where(number > 0, own @ np.where(finite, ratio, 0.0) / np.maximum(number, 1.0), np.nan)
    enough = (number > 0).sum(axis=0) >= SPEEDS
    out = np.full(ratio.shape[1], np.nan)
    out[enough] = np.nanmedian(means[:, enough], axis=0) if enough.any() else np.nan
    return out
