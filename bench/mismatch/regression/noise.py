"""The noise floor of a channel: a mixture of parts with different correlation times, read from the recordings' spectra.

The power spectral densities of all steady parts are laid over each other in hertz. A wave of the gearbox stands in a
few bins and moves with the speed; noise is in every bin of every recording. So the median over recordings and
neighbouring bins is that of the noise, whatever physics the recordings hold, and it does not grow with what a model
leaves out.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.special import chdtri

from bench.mismatch.recordings.rows import Rows, lively
from bench.mismatch.recordings.vibration import NYQUIST_SHARE, Density
from bench.simulation.frame import FloatArray, Frame, IntArray, recording_starts

MEMORIES_S = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
"""correlation times of the parts, s"""
SLOW_MEMORIES_S = (*MEMORIES_S, 10.0, 30.0)
"""the same of a thermometer's: the air about it moves"""
BINS = 40
"""bins of the pooled spectrum, even in the logarithm of the frequency"""
LOWEST_HZ = 0.15
"""below it a spectrum of ten seconds tells noise and drift no more apart"""
FEWEST_SPECTRA = 3
AS_ONE = 0.1
"""of a memory between samples, below which the mean of many is that of the noise over time (its square over twelve)"""
MANY = 100.0
"""samples, of fewer than which each counts"""
ALIKE_RAD = 0.1
"""angle over which an error of a series stays alike: a period of order sixty"""
NORMAL_QUARTILES = 1.349
"""distance of the quartiles of a normal distribution, in standard deviations"""
CLASSES = 3
"""kinds of motion with a scatter of their own: steady, changing, just after a start or reversal"""
_FEWEST = 30
_LAGS = (1, 2, 3, 4, 6)
_SLOW_LAGS = (*_LAGS, 9, 13)
"""rows between those that are compared; of a channel that changes slowly"""
AS_NEAR = 0.15
"""relative error with which noise alone may say how rows differ: that of a variance from a hundred of them"""
_OF_ROWS = 0.1
"""share of the rows that those of about as many samples are at least: others are the ends of recordings"""
_RUNNING = 9
"""rows of a running mean, and rows of a kind from which its scatter is estimated separately"""


@dataclass(frozen=True, slots=True)
class Mixture:
    """Noise of single samples: ``white`` variance, and ``parts`` (variance each) with the correlation times
    ``memories`` in s.

    ``rate``: sample rate in Hz that the white part belongs to.
    """

    white: float
    parts: tuple[float, ...]
    rate: float
    memories: tuple[float, ...] = MEMORIES_S

    @property
    def variance(self) -> float:
        """Variance of a single sample."""
        return self.white + sum(self.parts)

    def at_most(self, variance: float) -> Mixture:
        """The mixture, of no larger variance of a single sample than given."""
        share = min(1.0, variance / max(self.variance, 1e-300))
        return replace(self, white=share * self.white, parts=tuple(share * v for v in self.parts))

    def density(self, frequency: FloatArray) -> FloatArray:
        """One-sided spectral density of the samples at ``frequency`` Hz (any shape)."""
        out = np.full(np.shape(frequency), 2.0 * self.white / self.rate)
        for variance, memory in zip(self.parts, self.memories, strict=True):
            out = out + 4.0 * variance * memory / (1.0 + (2.0 * np.pi * frequency * memory) ** 2)
        return np.asarray(out)

    def of_means(self, number: FloatArray, duration: FloatArray) -> FloatArray:
        """Variance of means over ``number`` samples, spread over ``duration`` s (n,)."""
        samples = np.maximum(number, 1.0)
        out = self.white / samples
        for variance, memory in zip(self.parts, self.memories, strict=True):
            x = np.maximum(duration / memory, 1e-6)
            close = np.where(x < 1e-3, 1.0 - x / 3.0, 2.0 * (x - 1.0 + np.exp(-x)) / x**2)
            # samples further apart than the noise remembers are independent: the sum of their correlations
            step = np.maximum(x / samples, 1e-4)
            unlike, alike = -np.expm1(-step), np.exp(-step)
            apart = (1.0 + alike + 2.0 * alike * np.expm1(-samples * step) / (samples * unlike)) / unlike / samples
            over_time = (x < 1e-3) | ((x < AS_ONE * samples) & (samples > MANY))
            out = out + variance * np.where(over_time, close, apart)
        return np.asarray(out)

    def across(self, first: FloatArray, second: FloatArray, gap: FloatArray) -> FloatArray:
        """Covariance of means over two durations, ``gap`` s apart (n,)."""
        out = np.zeros(first.size)
        for variance, memory in zip(self.parts, self.memories, strict=True):
            a, b = np.maximum(first / memory, 1e-6), np.maximum(second / memory, 1e-6)
            out += variance * (1.0 - np.exp(-a)) * (1.0 - np.exp(-b)) / (a * b) * np.exp(-gap / memory)
        return out


@dataclass(frozen=True, slots=True)
class RowNoise:
    """Noise of rows (n,): standard deviation, and correlation with the row before (0 in a recording's first)."""

    sigma: FloatArray
    correlation: FloatArray
    memory: float
    """time after which noise has mostly forgotten itself, s"""
    independent_rows: float | None = None
    """rows of independent noise that say as much as all of these, where a motion of its own kind was repeated or cut:
    nothing but the model's residual tells its noise, and a number costs its description
    """


def mixture(densities: Sequence[Density]) -> Mixture | None:
    """Noise of the samples from the recordings' spectra; None where too few have one."""
    kinds_of = [(d.rate, d.power.size) for d in densities]
    if len(kinds_of) < FEWEST_SPECTRA:
        return None
    usual = max(set(kinds_of), key=kinds_of.count)
    rate = usual[0]
    usual_ones = [d for d in densities if (d.rate, d.power.size) == usual]
    step = usual_ones[0].step
    frequency = step * np.arange(usual_ones[0].power.size)
    edges = np.geomspace(LOWEST_HZ, NYQUIST_SHARE * rate, BINS + 1)
    # a median of averaged periodograms lies below their mean by that of a chi-square variable
    bias = np.array([chdtri(2.0 * d.averaged, 0.5) / (2.0 * d.averaged) for d in usual_ones])
    table = np.array([d.power / b for d, b in zip(usual_ones, bias, strict=True)])
    at: list[float] = []
    level: list[float] = []
    for low, high in itertools.pairwise(edges):
        chosen = (frequency >= low) & (frequency < high)
        if chosen.any():
            at.append(float(np.sqrt(low * high)))
            level.append(float(np.median(np.median(table[:, chosen], axis=1))))
    return fitted(np.asarray(at), np.asarray(level), rate)


def fitted(frequency: FloatArray, level: FloatArray, rate: float) -> Mixture:
    """Mixture whose spectrum comes nearest to a one-sided density ``level`` (k,) at ``frequency`` (k,) Hz."""
    good = level > 0.0
    frequency, level = frequency[good], level[good]
    columns = [np.full(frequency.size, 2.0 / rate)]
    columns += [4.0 * m / (1.0 + (2.0 * np.pi * frequency * m) ** 2) for m in MEMORIES_S]
    found, _ = _fitted(np.column_stack(columns) / level[:, None])
    return Mixture(float(found[0]), tuple(float(v) for v in found[1:]), rate)


def kinds(frame: Frame) -> IntArray:
    """Kind of motion of each row: 0 steady, 1 changing, 2 just after a start or reversal."""
    out = np.where(frame.steady > 0.5, 0, 1)
    return np.asarray(np.where(lively(frame) & (frame.steady < 0.5), 2, out), dtype=np.int64)


def usual_rate(frame: Frame) -> float:
    """Samples a second in the recording that the middle one of all samples is in: some are recorded more slowly."""
    if frame.size == 0:
        return 0.0
    samples, rates = _rates(frame)
    order = np.argsort(rates)
    return float(rates[order][np.searchsorted(np.cumsum(samples[order]), 0.5 * float(samples.sum()))])


def durations(frame: Frame) -> FloatArray:
    """How long each row lasts (n,), s, at the rate of its own recording."""
    return np.asarray(frame.count / _rates(frame)[1][frame.recording])


def _rates(frame: Frame) -> tuple[FloatArray, FloatArray]:
    """Samples of each recording by its index, and samples a second."""
    within = np.ones(frame.size, dtype=bool)
    within[recording_starts(frame)[:-1]] = False  # there a step is from the recording before
    samples = np.bincount(frame.recording, frame.count)
    counted, seconds = (np.bincount(frame.recording, np.where(within, v, 0.0)) for v in (frame.count, frame.step))
    usual = float(counted.sum()) / max(float(seconds.sum()), 1e-9)
    return np.asarray(samples, dtype=np.float64), np.where(seconds > 0.0, counted / np.maximum(seconds, 1e-9), usual)


def middle_variance(variance: FloatArray, freedom: FloatArray) -> float:
    """Median of estimates of a variance (n,), each over that of a chi-square with its own degrees of freedom (n,): the
    median of few is below their mean (Wilson and Hilferty, PNAS 17 (1931) 684).
    """
    return float(np.median(variance / (1.0 - 2.0 / (9.0 * freedom)) ** 3)) if variance.size else 0.0


def middles(variances: Sequence[FloatArray]) -> FloatArray:
    """Middle of each recording's estimates of a variance, as that of chi-squares whose degrees of freedom their scatter
    tells.

    A transmitter that reads a few times a second repeats its readings: a row of hundreds of samples holds two or three.
    The cube root of a chi-square of k degrees of freedom over k is normal, its mean 1 - x and its variance
    x = 2/(9 k) (Wilson and Hilferty, PNAS 17 (1931) 684).
    """
    roots = [np.cbrt(values) for values in variances]
    middles = np.asarray([np.median(root) for root in roots])
    relative = [root / middle for root, middle in zip(roots, middles, strict=True) if middle > 0.0]
    if not relative:
        return np.zeros(len(roots))
    low, high = np.quantile(np.concatenate(relative), [0.25, 0.75])
    spread = ((high - low) / NORMAL_QUARTILES) ** 2
    # x/(1 - x)**2 = spread
    x = 2.0 * spread / (2.0 * spread + 1.0 + np.sqrt(4.0 * spread + 1.0))
    return np.asarray((middles / (1.0 - x)) ** 3)


def of_each(rows: Rows, chosen: NDArray[np.bool_] | IntArray) -> FloatArray:
    """Variance of a sample as each of the ``chosen`` rows, of more than one, estimates it (chosen,)."""
    number = rows.number[chosen]
    return np.asarray(rows.within[chosen] * number / (number - 1.0))


def of_samples(within: FloatArray, number: FloatArray) -> float:
    """Variance of a sample, from the variance ``within`` rows (n,) of a ``number`` of samples each, more than one."""
    freedom = number - 1.0
    return middle_variance(within * number / freedom, freedom)


def robust_spread(values: FloatArray) -> float:
    """Standard deviation of the bulk: values beyond four spreads (by the median) are clipped to that."""
    if values.size < 4:
        return float(np.std(values)) if values.size else 0.0
    middle = float(np.median(values))
    spread = 1.4826 * float(np.median(np.abs(values - middle)))
    if spread == 0.0:
        return float(np.std(values))
    return float(np.sqrt(np.mean(np.clip(values - middle, -4.0 * spread, 4.0 * spread) ** 2)))


def plain_mixture(rows: Rows, residual: FloatArray, slow: bool = False) -> Mixture:
    """Noise from how much rows a few steps apart differ: where recordings are too short, or too slow, for spectra.

    What changes slowly, physics above all, hardly differs over a few rows (structure function, Cressie, Statistics for
    Spatial Data, 1993, ch. 2). ``slow``: the channel changes so slowly that samples in a row differ by noise alone.
    Then their scatter says how quickly it forgets itself, which rows a few steps apart do not: rows of a recording
    with fewer samples are as sure as others, if that is slower than its samples.
    """
    frame = rows.frame
    rate = usual_rate(frame)
    number = float(np.median(rows.number)) or 1.0
    groups = [np.ones(rows.size, dtype=bool)]
    if slow:  # elsewhere rows are short where something changes, which is no matter of how many samples they have
        alike = np.round(np.log2(np.maximum(rows.number, 1.0)))
        groups = [alike == k for k in np.unique(alike) if np.mean(alike == k) >= _OF_ROWS]
    lags, memories = (_SLOW_LAGS, SLOW_MEMORIES_S) if slow else (_LAGS, MEMORIES_S)
    found_of = [(_differences(rows, residual, group, lags, memories), group) for group in groups]
    equations = [equation for equation, _ in found_of if equation is not None]
    if slow:
        equations += [_scatter(rows, group, memories) for equation, group in found_of if equation is not None]
    if not equations:
        spread = robust_spread(np.diff(residual)) ** 2 / 2.0 if residual.size > 1 else 1.0
        return Mixture(max(spread * number, 1e-300), (0.0,) * len(memories), rate, memories)
    design = np.vstack([design / measured[:, None] for design, measured in equations])
    found, missed = _fitted(design)
    if slow:
        # what grows with the lag may be a memory or a rest: where a memory alone says it, it is one
        alone, missed_alone = _fitted(np.delete(design, -1, axis=1))
        if missed_alone < max(AS_NEAR, missed):
            found = np.append(alone, 0.0)
    return Mixture(float(found[0]), tuple(float(v) for v in found[1:-1]), rate, memories)


def _fitted(design: FloatArray) -> tuple[FloatArray, float]:
    """Coefficients (k,), none below zero, with which columns (n, k) come nearest to one, and by how much they miss it
    (root mean square).
    """
    scale = np.maximum(np.abs(design).max(axis=0), 1e-300)
    found, missed = nnls(design / scale, np.ones(len(design)))
    return np.asarray(found / scale), float(missed) / np.sqrt(len(design))


def _differences(
    rows: Rows, residual: FloatArray, chosen: NDArray[np.bool_], lags: Sequence[int], memories: Sequence[float]
) -> tuple[FloatArray, FloatArray] | None:
    """By how much the ``chosen`` rows, of about as many samples, differ over ``lags`` of a few rows: the equations of a
    mixture's parts with ``memories`` and of what is slow beside them (lags, 2 + parts), and half the mean square that
    was measured (lags,). None where they are too few.
    """
    frame = rows.frame
    number, step = float(np.median(rows.number[chosen])), float(np.median(durations(frame)[chosen]))
    differ = []
    for lag in lags:
        near = (frame.recording[lag:] == frame.recording[:-lag]) & chosen[lag:] & chosen[:-lag]
        near &= np.abs(frame.elapsed[lag:] - frame.elapsed[:-lag] - lag * step) < 0.5 * step
        change = (residual[lag:] - residual[:-lag])[near]
        differ.append(0.5 * robust_spread(change) ** 2 if change.size >= _FEWEST else np.nan)
    measured = np.asarray(differ)
    good = np.isfinite(measured) & (measured > 0.0)
    if good.sum() < 3:
        return None
    duration = np.full(len(lags), step)
    columns = [np.full(len(lags), 1.0 / number)]
    for memory in memories:
        alone = Mixture(0.0, (1.0,), 1.0, (memory,))
        variance = alone.of_means(np.full(1, number), np.full(1, step))[0]
        columns.append(variance - alone.across(duration, duration, (np.asarray(lags) - 1.0) * step))
    # the slow rest of a residual grows with the square of the lag: it is fitted beside the noise
    columns.append(np.asarray(lags, dtype=np.float64) ** 2 * float(np.nanmax(measured)))
    return np.column_stack(columns)[good], measured[good]


def _scatter(rows: Rows, chosen: NDArray[np.bool_], memories: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """The same equations (1, 2 + parts) of how samples scatter inside the ``chosen`` rows: by what a mean over a row
    does not hold of them. None (0, 2 + parts) where rows are single samples.
    """
    inside = chosen & (rows.number > 1.5)
    scatter = float(middles([of_each(rows, inside)])[0]) if inside.any() else 0.0
    if scatter <= 0.0:
        return np.zeros((0, 2 + len(memories))), np.zeros(0)
    number, step = float(np.median(rows.number[inside])), float(np.median(durations(rows.frame)[inside]))
    kept = [Mixture(0.0, (1.0,), 1.0, (m,)).of_means(np.full(1, number), np.full(1, step))[0] for m in memories]
    column = [1.0, *((1.0 - share) * number / (number - 1.0) for share in kept), 0.0]
    return np.array([column]), np.full(1, scatter)


def of_rows(rows: Rows, noise: Mixture, residual: FloatArray, doubt: FloatArray | None = None) -> RowNoise:
    """Noise of rows from that of the samples; a kind of motion whose ``residual`` (n,) scatters more has more.

    Rows are of several recordings, in order. ``doubt`` (n,): variance of what was taken off the rows before; it is the
    same for rows near each other in the angle.
    """
    frame = rows.frame
    starts = recording_starts(frame)
    duration = durations(frame)
    variance = noise.of_means(rows.number, duration)
    gap = np.zeros(frame.size)
    gap[1:] = np.maximum(np.diff(frame.elapsed) - 0.5 * (duration[1:] + duration[:-1]), 0.0)
    shared = np.zeros(frame.size)
    shared[1:] = noise.across(duration[1:], duration[:-1], gap[1:])
    if doubt is not None:
        variance = variance + doubt
        apart = np.abs(np.diff(frame.theta))
        shared[1:] += np.sqrt(doubt[1:] * doubt[:-1]) * np.exp(-apart / ALIKE_RAD)
    shared[starts[:-1]] = 0.0
    sigma = np.sqrt(np.maximum(variance, 1e-300))
    correlation = np.zeros(frame.size)
    correlation[1:] = np.clip(shared[1:] / (sigma[1:] * sigma[:-1]), 0.0, 0.98)
    kind = kinds(frame)
    scale = np.ones(frame.size)
    steps = innovations(residual, sigma, correlation, starts)
    for k in range(CLASSES):
        of_kind = kind == k
        if of_kind.sum() >= _FEWEST:
            # differences to neighbours: a kind of motion is not noisier for the physics that shows in it
            spread = robust_spread(steps[of_kind] - _running(steps[of_kind])) / np.sqrt(1.0 - 1.0 / _RUNNING)
            scale[of_kind] = max(spread, 0.5)
    heavy = [m for v, m in zip(noise.parts, noise.memories, strict=True) if v > 0.02 * noise.variance]
    return RowNoise(sigma * scale, correlation, max(heavy, default=MEMORIES_S[0]))


def alike(rows: Rows, residual: FloatArray) -> RowNoise:
    """Noise of rows where no spectra tell it: all alike, as large as the ``residual`` (n,), each by itself.

    The residual of such recordings, short or never steady, holds the physics that is looked for. To whiten by how it
    remembers itself would take away just that, and keep the frequencies at which regressors, rates above all, are
    least true. Working independence costs efficiency only (Liang and Zeger, Biometrika 73 (1986) 13); what a gain is
    worth is asked of the signs of blocks.
    """
    weight = np.maximum(rows.number, 0.0)
    spread = float(np.sqrt(np.sum(weight * residual**2) / max(float(weight.sum()), 1e-300)))
    sigma = np.full(rows.size, max(spread, 1e-150))
    return RowNoise(sigma, np.zeros(rows.size), MEMORIES_S[0])


def of_free_motion(rows: Rows, residual: FloatArray) -> RowNoise:
    """Noise of rows of a motion that follows no set speeds: all alike, and larger by as many rows as say one thing."""
    noise = alike(rows, residual)
    rows_alike = alike_for(residual, recording_starts(rows.frame))
    return replace(noise, sigma=noise.sigma * np.sqrt(rows_alike), independent_rows=rows.size / rows_alike)


def alike_for(residual: FloatArray, starts: IntArray) -> float:
    """Rows of a residual (n,) that say as much as one row of independent noise: 1 + 2*sum of the autocorrelations.

    Summed as far as pairs of neighbouring ones stay above 0 (Geyer, Stat. Sci. 7 (1992) 473).
    """
    parts = [residual[a:b] for a, b in itertools.pairwise(starts)]
    square = sum(float(part @ part) for part in parts)
    longest = max((part.size for part in parts), default=0)
    if square <= 0.0:
        return 1.0
    total, lag = 1.0, 1
    while lag + 1 < longest:
        pair = sum(float(part[k:] @ part[:-k]) for k in (lag, lag + 1) for part in parts if part.size > k) / square
        if pair <= 0.0:
            break
        total += 2.0 * pair
        lag += 2
    return total


def innovations(values: FloatArray, sigma: FloatArray, correlation: FloatArray, starts: IntArray) -> FloatArray:
    """Values (n,) in units of their noise, less what the row before says of them."""
    scaled = values / sigma
    rho = correlation.copy()
    rho[starts[:-1]] = 0.0
    out = scaled.copy()
    out[1:] -= rho[1:] * scaled[:-1]
    return np.asarray(out / np.sqrt(1.0 - rho**2))


def _running(values: FloatArray) -> FloatArray:
    """Running mean over a few rows: the slow part of a residual."""
    total = np.cumsum(np.concatenate(([0.0], np.pad(values, _RUNNING // 2, mode="edge"))))
    return np.asarray((total[_RUNNING:] - total[:-_RUNNING]) / _RUNNING)
