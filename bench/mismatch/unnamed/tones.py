"""A tone: a disturbance of one frequency over time, in recordings of whatever speed.

An order of the gearbox moves with the speed, a tone stands at its hertz. So the spectra are compared by speed: at each
frequency the median over the speeds of the power over the noise about it. What the largest such median is in noise is
drawn from the law of averaged periodograms. A tone that comes at some states alone, a shaft that whirls or chatters,
stands at one frequency at some speeds (:mod:`bench.mismatch.unnamed.some_speeds`).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter, percentile_filter
from scipy.stats import chi2

from bench.mismatch import criteria
from bench.mismatch.recordings.vibration import NYQUIST_SHARE, Density
from bench.mismatch.regression.maxima import tail_probability
from bench.mismatch.regression.noise import LOWEST_HZ
from bench.mismatch.unnamed.some_speeds import SPEEDS, at_some_speeds
from bench.mismatch.unnamed.spectral_line import mean_square, measured
from bench.simulation.frame import FloatArray, IntArray
from bench.simulation.terms.te.resonance import ZETAS

ALIKE = 0.03
"""relative difference of speeds that count as one"""
SURROGATES = 200
MOST_FREQUENCIES = 400
"""that a surrogate has"""
_LEAK = 2
"""bins to either side of an order that its line reaches in a Hann window"""
_FURTHEST = 12
"""bins to either side at which a line of a million times the noise has fallen to it"""
MEDIAN_ERROR = 1.253
"""standard deviation of a median over that of the mean of as many: the square root of pi/2"""
_ABOUT = 41
"""frequencies whose median tells the noise at one"""
_FEWEST_ABOUT = 7
"""of them that no order covers: their median is known to a fifth"""
MOST_AMPLIFIED = 1.0 / (2.0 * ZETAS[0])
"""times that a mode makes an order larger in a torque than inertia alone: at resonance, with the least damping that the
library begins with
"""
FELT_DOUBT = 2.0
"""times that an order may be felt more than that, by a damping of half as much, or as inertia and amplitude are not
known better
"""
OF_THE_LOUD = 0.25
"""power of a line over its median in the recordings that clearly have one, from which a recording has it: half of its
size
"""
QUIETER_BY = criteria.SHAPE**2
"""of that power, that all other recordings have less of: so little is no form of the same tone"""
LEAST_WITHOUT = 0.25
"""share of the recordings that have no line, from which it is one of some recordings"""
_QUIET = 25.0
"""percentile of the power about a frequency that is its noise at least, though orders stand there"""


@dataclass(frozen=True, slots=True)
class Tone:
    """Frequency (Hz) and amplitude with their standard deviations, chance in noise, the recordings by power, and the
    tone's mean square in each of them; ``everywhere``: whether it was heard at most speeds, and not at some;
    ``heard``: recordings in which nothing known covers it, the strongest first, of those that tell the frequency.
    """

    frequency: float
    frequency_std: float
    amplitude: float
    amplitude_std: float
    p_value: float
    recordings: tuple[int, ...]
    squares: tuple[float, ...] = ()
    everywhere: bool = True
    heard: tuple[int, ...] = ()


def tone(
    densities: Sequence[Density],
    seed: int,
    orders: Sequence[float] = (),
    unsteady: Sequence[Density] = (),
    *,
    felt: Sequence[float] | None = None,
) -> Tone | None:
    """The clearest tone of a channel; None where the spectra cannot tell one from orders.

    Frequencies of ``orders`` known to be there are left out of each recording. A torque feels them by inertia alone:
    where ``felt`` says by how much (amplitude at 1 rad/s, as the square of the frequency), those are left out that a
    mode may lift above the noise, where what stands there is no more than that. ``unsteady`` are asked for the size of
    the tone, not whether there is one.
    """
    kinds = [(d.rate, d.power.size) for d in densities]
    if not kinds:
        return None
    usual = max(set(kinds), key=kinds.count)
    rate = usual[0]
    comparable = [d for d in densities if (d.rate, d.power.size) == usual]
    groups = _speeds(np.array([d.rotation_rate for d in comparable]))
    if groups.max(initial=-1) + 1 < SPEEDS:
        return None
    step = comparable[0].step
    first, last = int(np.ceil(LOWEST_HZ / step)), int(NYQUIST_SHARE * rate / step)
    power = np.array([d.power[first:last] for d in comparable], dtype=np.float64)
    covered, leaked = np.zeros(power.shape, dtype=bool), np.zeros(power.shape)
    freedom = np.array([2.0 * d.averaged for d in comparable])
    for k, density in enumerate(comparable):
        hertz = np.asarray(orders, dtype=np.float64) * density.rotation_rate
        bins = np.round(hertz / step).astype(int) - first
        stand = (bins >= 0) & (bins < power.shape[1])
        if felt is not None:
            stand[stand] = _may_be(
                power[k], bins[stand], np.asarray(felt)[stand] * (2.0 * np.pi * hertz[stand]) ** 2, step
            )
        covered[k], leaked[k] = _lines(power[k], bins[stand], first)
    # the median of an exponential variable is ln 2 of its mean; of averaged ones it comes nearer to the mean
    levels = [_level(row, lines, felt is not None) for row, lines in zip(power, covered, strict=True)]
    level = leaked + np.array([one for one, _ in levels])
    ratio = np.where(covered, np.nan, power / np.maximum(level, 1e-300))
    # how surely a median of so many frequencies tells the noise
    unsure = MEDIAN_ERROR * np.sqrt(2.0 / freedom)[:, None] / np.sqrt([number for _, number in levels])
    means = _means(ratio, groups)
    statistic = _median(means)
    frequencies = min(ratio.shape[1], MOST_FREQUENCIES)
    looked = np.isfinite(ratio)
    if looked.all():
        largest = _largest(tuple(freedom.tolist()), tuple(groups.tolist()), frequencies, seed)
    else:
        # where orders cover most speeds, the few that are left scatter more
        largest = _drawn(freedom, groups, frequencies, seed, looked, unsure)
    if not np.isfinite(statistic).any():
        return None
    peak = int(np.nanargmax(statistic))
    # surrogates of some frequencies stand for all: the maximum of m blocks
    blocks = max(ratio.shape[1] / MOST_FREQUENCIES, 1.0)
    p = blocks * tail_probability(largest, float(statistic[peak]), 0.0)
    beyond = np.pad(np.where(covered, np.nan, power - level), ((0, 0), (1, 1)), constant_values=np.nan)
    rows = np.arange(len(comparable))
    some = at_some_speeds(means, np.arange(first, last))
    everywhere = some is None or some.p_value >= p
    if some is not None and not everywhere:
        peak, p = some.frequency, some.p_value
        rows = np.flatnonzero(np.nan_to_num(ratio[:, peak]) >= some.least)
    else:
        loud = _loud(ratio[:, peak], beyond[:, peak + 1], freedom)
        if loud is not None:
            # it is surely there, but not in all recordings: its size is that of those that have it
            rows, everywhere = loud, False
    peak = _crest(ratio[rows], peak)
    line = measured(beyond[rows, peak : peak + 3], step, seed)
    at = first + peak + line.offset
    held = {comparable[k].recording: float(square) for k, square in zip(rows, line.squares, strict=True)}
    held |= {d.recording: _mean_square(d, at * step) for d in (*comparable, *unsteady) if d.recording not in held}
    strongest = sorted(held, key=lambda recording: -held[recording])
    squares = tuple(held[recording] for recording in strongest)
    clear = {comparable[k].recording for k in rows if np.isfinite(beyond[k, peak : peak + 3]).all()}
    heard = tuple(recording for recording in strongest if recording in clear)
    # two ways to be a tone were asked
    p = float(np.clip(2.0 * p, criteria.LEAST_P, 1.0))
    if not _stands_out(power[rows], np.isfinite(ratio[rows, peak]), peak):
        p = 1.0
    size = (line.amplitude, line.amplitude_std)
    return Tone(at * step, line.offset_std * step, *size, p, tuple(strongest), squares, everywhere, heard)


def _loud(ratio: FloatArray, beyond: FloatArray, freedom: FloatArray) -> IntArray | None:
    """Recordings (k,) that have a line: its power over the noise ``ratio`` (n,), ``beyond`` the noise (n,), of spectra
    of so many degrees of ``freedom`` (n,). None where hardly any is without it, or those without it may have a smaller
    one.
    """
    seen = np.isfinite(beyond) & np.isfinite(ratio)
    chance = criteria.ERROR_RATE_OF_A_CHANNEL
    clear = seen & (np.nan_to_num(ratio) > chi2.isf(chance, freedom) / chi2.median(freedom))
    if int(clear.sum()) < SPEEDS:
        return None
    usual = float(np.median(beyond[clear]))
    loud = clear & (beyond >= OF_THE_LOUD * usual)
    quiet = beyond[seen & ~loud]
    few = quiet.size < LEAST_WITHOUT * int(seen.sum())
    if few or int(loud.sum()) < SPEEDS or quiet.max() > QUIETER_BY * np.median(beyond[loud]):
        return None
    return np.flatnonzero(loud)


def _stands_out(power: FloatArray, looked: NDArray[np.bool_], peak: int) -> bool:
    """Whether a line at a ``peak`` is larger than what is about it in spectra (recordings, f), orders included, where
    nothing covers it (recordings,): what a pulse leaves has all orders, and between those that are known it is no line.
    """
    first = max(peak - _ABOUT // 2, 0)
    about = np.median(power[:, first : peak + _ABOUT // 2 + 1], axis=1)
    return bool(np.mean(np.log(np.maximum(power[looked, peak], 1e-300) / np.maximum(about[looked], 1e-300))) > 0.0)


def _crest(ratio: FloatArray, peak: int) -> int:
    """The loudest frequency of a line that stands out at a ``peak``, in the geometric mean of the power over the noise
    (rows, frequencies): where it is far above the noise, the frequencies beside it may stand out as surely, and what
    else is in one recording counts little.
    """
    first = max(peak - _LEAK, 0)
    near = np.maximum(ratio[:, first : peak + _LEAK + 1], 1.0)
    number = np.isfinite(near).sum(axis=0)
    mean = np.nansum(np.log(near), axis=0) / np.maximum(number, 1)
    # a frequency that few recordings have not covered says little
    return first + int(np.argmax(np.where(2 * number >= number[peak - first], mean, -np.inf)))


def _mean_square(one: Density, frequency: float) -> float:
    """Mean square of a line at a ``frequency`` beyond the noise about it."""
    at = round(frequency / one.step)
    near = one.power[max(at - _ABOUT // 2, 1) : at + _ABOUT // 2 + 1]
    if not 0 < at < one.power.size - 1:
        return 0.0
    beyond = np.asarray(one.power[at - 1 : at + 2], dtype=np.float64) - float(np.median(near))
    return float(mean_square(beyond, frequency / one.step - at, one.step))


def _may_be(power: FloatArray, bins: IntArray, amplitude: FloatArray, step: float) -> NDArray[np.bool_]:
    """Which lines (n,) at some ``bins`` of a spectrum may be orders of an ``amplitude`` (n,) without a mode: a mode may
    lift them above the noise about them, and what stands there is no more than it may lift all that reach there.
    """
    largest = 0.5 * (FELT_DOUBT * MOST_AMPLIFIED * amplitude) ** 2
    reach = np.ones(2 * _LEAK + 1)
    total = np.convolve(power * step, reach, "same")[bins]
    together = np.convolve(np.bincount(bins, largest, power.size), np.ones(4 * _LEAK + 1), "same")[bins]
    noise = np.asarray(percentile_filter(power, _QUIET, _ABOUT, mode="nearest"))[bins] * reach.size * step
    return np.asarray((largest >= noise) & (total <= together + noise))


def _lines(power: FloatArray, bins: IntArray, first: int) -> tuple[NDArray[np.bool_], FloatArray]:
    """Frequencies (f,) of a spectrum that orders at some ``bins`` cover, and the power (f,) that their lines and the
    images of these at negative frequencies leak further off at most: the side lobes of a Hann window (Harris, Proc.
    IEEE 66 (1978) 51). ``first``: frequency of the first bin, in bins.
    """
    covered, amplitude = np.zeros(power.size, dtype=bool), np.zeros(power.size)
    further = np.arange(_LEAK + 1, _FURTHEST + 1)
    lobes = 1.0 / (further * (further**2 - 1.0))
    for k in bins:
        size = float(np.sqrt(power[max(k - _LEAK, 0) : k + _LEAK + 1].max()))
        covered[max(k - _LEAK, 0) : k + _LEAK + 1] = True
        for at in (k - further, k + further, further - k - 2 * first):
            inside = (at >= 0) & (at < power.size)
            amplitude[at[inside]] += size * lobes[inside]
    return covered, amplitude**2


def _level(power: FloatArray, covered: NDArray[np.bool_], faint: bool = False) -> tuple[FloatArray, FloatArray]:
    """Median power (f,) about each frequency, of those that no order ``covered``, and their number (f,): a gearbox's
    orders stand so close at low frequencies that the median of all would be theirs. Where fewer than
    :data:`_FEWEST_ABOUT` are left it is NaN, or that of all where orders are ``faint``: it is not below the noise.
    """
    out = np.asarray(median_filter(power, _ABOUT, mode="nearest"))
    numbers = np.full(power.size, float(_ABOUT))
    if not covered.any():
        return out, numbers
    last = int(np.flatnonzero(covered)[-1]) + _ABOUT // 2 + 1
    alone = np.where(covered, np.nan, power)
    for k in range(min(last, power.size)):
        # as far to either side: noise falls with the frequency, and what lies to one side alone is no measure
        half = min(_ABOUT // 2, k, power.size - 1 - k)
        about = alone[k - half : k + half + 1]
        about = about[np.isfinite(about)]
        if about.size >= _FEWEST_ABOUT:
            out[k], numbers[k] = np.median(about), about.size
        elif not faint:
            out[k] = np.nan
    return out, numbers


@lru_cache(maxsize=4)
def _largest(freedom: tuple[float, ...], groups: tuple[int, ...], frequencies: int, seed: int) -> FloatArray:
    """The clearest tone in surrogates of noise (SURROGATES,), whose spectra have degrees of ``freedom`` and are of the
    speeds ``groups``. The channels of a folder mostly have both in common.
    """
    return _drawn(np.asarray(freedom), np.asarray(groups), frequencies, seed, None)


def _drawn(
    freedom: FloatArray,
    groups: IntArray,
    frequencies: int,
    seed: int,
    looked: NDArray[np.bool_] | None,
    unsure: FloatArray | None = None,
) -> FloatArray:
    """The same where the spectra were ``looked`` at (recordings, all frequencies) in part (None: everywhere), and how
    ``unsure`` the noise about each frequency is there, a standard deviation over its size.
    """
    rng = np.random.default_rng([seed, 7])
    out = np.empty(SURROGATES)
    for k in range(SURROGATES):
        drawn = rng.chisquare(freedom[:, None], size=(freedom.size, frequencies))
        drawn /= np.median(drawn, axis=1, keepdims=True)
        if looked is not None:
            at = rng.integers(looked.shape[1], size=frequencies)
            if unsure is not None:
                drawn /= np.exp(unsure[:, at] * rng.normal(size=drawn.shape))
            drawn[~looked[:, at]] = np.nan
        out[k] = np.nanmax(_median(_means(drawn, groups)), initial=0.0)
    return out


def _speeds(rates: FloatArray) -> IntArray:
    """Number of the speed that each recording was driven at."""
    order = np.argsort(rates)
    out = np.zeros(rates.size, dtype=np.int64)
    number = 0
    for before, here in itertools.pairwise(order):
        number += rates[here] > (1.0 + ALIKE) * rates[before] + 1e-9
        out[here] = number
    return out


def _means(ratio: FloatArray, groups: IntArray) -> FloatArray:
    """Mean over the recordings of each speed (speeds, frequencies); NaN where orders cover the frequency."""
    members = (groups == np.arange(int(groups.max()) + 1)[:, None]).astype(np.float64)
    finite = np.isfinite(ratio)
    number = members @ finite
    return np.where(number > 0, members @ np.where(finite, ratio, 0.0) / np.maximum(number, 1.0), np.nan)


def _median(means: FloatArray) -> FloatArray:
    """Median over the speeds; NaN where fewer than :data:`SPEEDS` have one: orders cover a frequency at some speeds."""
    enough = np.isfinite(means).sum(axis=0) >= SPEEDS
    out = np.full(means.shape[1], np.nan)
    out[enough] = np.nanmedian(means[:, enough], axis=0) if enough.any() else np.nan
    return out
