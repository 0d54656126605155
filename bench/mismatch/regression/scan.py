"""How much each candidate would gain beside a model, and what such a gain is worth in these very recordings.

The gain of a candidate of k columns is that of log-likelihood with everything else refitted, less what k columns gain
in noise. What the best of the whole bank gains in noise is measured on surrogates: the model's residual with the signs
of its blocks, and of the recordings' offsets, drawn at random (Hemerik, Goeman and Finos, J. R. Stat. Soc. B 82
(2020) 841, for scores; Westfall and Young 1993 for the maximum). Only products with y change, so hundreds of them are
cheap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.regression.bank import RIDGE, Bank, Fit
from bench.mismatch.regression.maxima import tail, tail_probability
from bench.mismatch.regression.sign_blocks import Units
from bench.simulation.frame import FloatArray

SURROGATES = 300
MOST_LEVERAGE = 0.95
SHARES = (1.0, 8.0, 64.0)
"""by which the variance of the offsets is divided where smaller ones are tried"""
NOISE_RATIO = 1.0
"""variance of the offsets, over that which noise gives a recording's mean, above which smaller ones are tried"""
LEAST_ENERGY_LEFT = 1e-4
"""share of a column's energy beside the offsets that is there beside the model, too; below, the model says it all"""
ROUNDING = 1e-10
"""share of a column's energy that is there beside the offsets, below which it is rounding"""


@dataclass(frozen=True, slots=True)
class Scan:
    """Gains of the candidates (m,) beside a model, net of what noise gives them; and the price of one.

    ``surrogate`` (SURROGATES,): the best net gain of the whole bank in each surrogate.
    """

    gain: FloatArray
    surrogate: FloatArray

    @property
    def price(self) -> float:
        """Net gain that noise reaches with the error rate of a channel: by a Gumbel law through the surrogates, and no
        less than their own quantile, where their tail is heavier.
        """
        if not np.isfinite(self.surrogate).all():  # no candidate has anything beside the model
            return float("inf")
        quantile = float(np.quantile(self.surrogate, 1.0 - criteria.ERROR_RATE_OF_A_CHANNEL))
        return max(tail(self.surrogate, criteria.ERROR_RATE_OF_A_CHANNEL), quantile)

    def p_value(self, gain: float) -> float:
        """Chance that the best of the whole bank gains as much in noise."""
        if not np.isfinite(self.surrogate).all():
            return 1.0
        return tail_probability(self.surrogate, gain)


def scan(
    bank: Bank,
    index: Sequence[int],
    precision: FloatArray,
    fitted: Fit,
    residual: FloatArray,
    candidates: Sequence[tuple[int, ...]],
    extra: FloatArray,
    blocks: Units,
    seed: int,
    shuffled: bool,
    least: float = LEAST_ENERGY_LEFT,
) -> Scan:
    """Scan ``candidates`` (numbers of their columns) beside the model of the columns ``index``.

    ``precision`` (k,) of the model's coefficients; ``fitted``: the model; ``residual`` (n,) whitened, of the model;
    ``extra`` (m,) parameters that a candidate has beyond its columns. Surrogates are the residual itself with its signs
    drawn (``shuffled``), which is right where nothing is left in it but noise; else noise as the model has it, with
    offsets of the variance that is likely whatever the coefficients are.

    An effect that differs from recording to recording swells the offsets' variance, and hides behind it. So smaller
    variances are tried as well (profile likelihood), in the recordings and in each surrogate alike; not with signs
    drawn, where the residual's own offsets stand for any variance.
    """
    variance = fitted.variance
    drawn_from = residual if shuffled else _noise(bank, fitted.spread, seed)
    at = _Products.of(bank, index, residual, drawn_from, blocks, seed, shuffled)
    looks = [
        _look(bank, at, precision, v, variance, candidates, least)
        for v in ([variance] if shuffled else _smaller(bank, fitted.spread))
    ]
    null = max(look.null for look in looks)
    nulls = np.max([look.nulls for look in looks], axis=0)
    likelihood = np.max([look.likelihood + (look.null - null) for look in looks], axis=0)
    noise = np.max([look.noise + (look.nulls - nulls)[:, None] for look in looks], axis=0)
    alive = looks[0].alive
    sizes = np.array([len(c) for c in candidates])
    # what its columns gain in these surrogates on the average, twice: once fitted, once more when predicted
    price = 2.0 * np.maximum(noise.mean(axis=0), 0.5 * sizes) + extra
    gain = np.where(alive, likelihood - price, -np.inf)
    best = np.where(alive, noise - price, -np.inf).max(axis=1, initial=-np.inf)
    return Scan(gain, best)


def _smaller(bank: Bank, variance: float) -> list[float]:
    """Variances of the offsets that are tried: the model's own, and smaller ones where it is more than noise."""
    if not np.isfinite(variance) or variance * float(np.median(bank.energy)) < NOISE_RATIO:
        return [variance]
    return [variance / share for share in SHARES]


@dataclass(frozen=True, slots=True)
class _Look:
    """At one variance of the offsets: log-likelihood of the model, of each surrogate (SURROGATES,), what each candidate
    gains in the recordings (m,) and in each surrogate (SURROGATES, m), which have anything beside the model (m,).
    """

    null: float
    nulls: FloatArray
    likelihood: FloatArray
    noise: FloatArray
    alive: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class _Products:
    """What every variance of the offsets has in common: products of all columns with those of the model (p, k) and with
    the residual (p,); those of the residual with the whitened one of each recording (recordings,); the parts that are
    drawn.
    """

    base: list[int]
    cross: FloatArray
    residual: FloatArray
    sums: FloatArray
    drawn: _Drawn

    @classmethod
    def of(
        cls,
        bank: Bank,
        index: Sequence[int],
        residual: FloatArray,
        drawn_from: FloatArray,
        blocks: Units,
        seed: int,
        fitted: bool,
    ) -> _Products:
        """Work them out once."""
        sums = bank.whitening.by_recording(bank.one * residual)
        with_residual = bank.columns.products(residual)
        return cls(
            list(index), bank.cross(list(index)), with_residual, sums, _Drawn.of(bank, drawn_from, blocks, seed, fitted)
        )


def _look(
    bank: Bank,
    at: _Products,
    precision: FloatArray,
    variance: float,
    likeliest: float,
    candidates: Sequence[tuple[int, ...]],
    least: float,
) -> _Look:
    """One look of :func:`scan`, at one ``variance`` of the offsets; what is drawn has offsets of the variance
    ``likeliest``.
    """
    base = at.base
    ones, _ = bank.sums()
    weight = bank.shrunk(variance)
    g = ones[:, base]
    cross = at.cross - (ones * weight[:, None]).T @ g
    gram = cross[base] + np.diag(precision)
    scale = np.sqrt(np.where(np.diag(gram) > 1e-200, np.diag(gram), 1.0))
    inverse = np.linalg.inv(gram / np.outer(scale, scale) + RIDGE * np.eye(len(base))) / np.outer(scale, scale)
    away = cross @ inverse
    # the model's residual has nothing of the model's own columns left: no large numbers cancel here
    net = at.residual - ones.T @ (weight * at.sums)
    # the coefficients are the best at another variance: how they are drawn at this one
    drawn_to = ones[:, base].T @ ((bank.shrunk(likeliest) - weight) * at.sums)
    null = _likelihood(bank, variance, at.sums[None], drawn_to[None], inverse)[0]
    net = net - away @ drawn_to

    drawn, sums = at.drawn.at(bank, variance, likeliest, g, inverse)
    nulls = _likelihood(bank, variance, sums, drawn[:, base], inverse)
    drawn = drawn - drawn[:, base] @ away.T

    likelihood = np.zeros(len(candidates))
    noise = np.zeros((SURROGATES, len(candidates)))
    alive = np.zeros(len(candidates), dtype=bool)
    sizes = np.array([len(c) for c in candidates])
    for k in np.unique(sizes):
        members = np.flatnonzero(sizes == k)
        indices = np.array([candidates[int(m)] for m in members])
        block_gram = np.stack([bank.block_gram(candidates[int(m)]) for m in members])
        offsets = np.moveaxis(ones[:, indices], 0, 1)
        full = block_gram - _transposed(offsets) @ (weight[:, None] * offsets)
        left = full - away[indices] @ _transposed(cross[indices])
        # beside offsets much larger than noise all that differs between recordings is small: it is the model that
        # may say a column, not its offsets
        whole, beside = np.einsum("mkk->mk", block_gram), np.einsum("mkk->mk", full)
        unit = np.sqrt(np.maximum(beside, np.maximum(ROUNDING * whole, 1e-300)))
        scaled = left / unit[:, :, None] / unit[:, None, :]
        alive[members] = np.einsum("mkk->mk", scaled).max(axis=1) > least
        ridge = np.maximum(1e-6 * np.einsum("mkk->m", scaled) / k, least * 1e-2)
        solved = np.linalg.inv(scaled + ridge[:, None, None] * np.eye(k))
        mine = (net[indices] / unit)[:, None, :]
        likelihood[members] = 0.5 * np.sum(mine @ solved * mine, axis=(1, 2))
        null_of = np.moveaxis(drawn[:, indices] / unit, 0, 1)
        noise[:, members] = 0.5 * np.sum(null_of @ solved * null_of, axis=2).T
    return _Look(float(null), nulls, likelihood, noise, alive)


def _transposed(matrices: FloatArray) -> FloatArray:
    return np.swapaxes(matrices, 1, 2)


def _likelihood(bank: Bank, variance: float, sums: FloatArray, net: FloatArray, inverse: FloatArray) -> FloatArray:
    """Log-likelihood (s,) of the model, but for what every variance has in common.

    ``sums`` (s, recordings): products of the residual with the whitened one; ``net`` (s, k): with the model's columns.
    """
    offsets = 0.5 * (sums**2) @ bank.shrunk(variance)
    return np.asarray(offsets + 0.5 * np.sum(net @ inverse * net, axis=1) - 0.5 * bank.cost(variance))


def _noise(bank: Bank, variance: float, seed: int) -> FloatArray:
    """Whitened noise (n,) as the model has it: independent rows, and an offset of each recording."""
    rng = np.random.default_rng([seed, 1])
    out = rng.normal(size=bank.y.size)
    if not np.isinf(variance):
        offset = rng.normal(size=bank.energy.size) * np.sqrt(variance)
        out += np.repeat(offset, np.diff(bank.whitening.starts)) * bank.one
    return out


@dataclass(frozen=True, slots=True)
class _Drawn:
    """Surrogates of a residual whose signs are drawn: of each recording's offset, and of each unit of what is left.

    ``mean`` (recordings,) offsets; ``columns`` (SURROGATES, p), ``ones`` (SURROGATES, recordings): products of what is
    left, signs drawn, with all columns and with the whitened one of each recording; ``signs`` (SURROGATES, recordings)
    of the offsets; ``fitted``: it is the residual of a fit.
    """

    mean: FloatArray
    columns: FloatArray
    ones: FloatArray
    signs: FloatArray
    fitted: bool

    @classmethod
    def of(cls, bank: Bank, residual: FloatArray, blocks: Units, seed: int, fitted: bool) -> _Drawn:
        """Cut a whitened ``residual`` (n,) into offsets and ``blocks``, and draw signs."""
        energy = np.maximum(bank.energy, 1e-300)
        mean, rest = bank.levels(residual), bank.about_levels(residual)
        # what is left has lost its mean in each recording: a degree of freedom of as many as it has blocks
        number = np.bincount(blocks.recording)[blocks.recording].astype(np.float64)
        freed = np.sqrt(number / np.maximum(number - 1.0, 0.5)) if fitted else np.ones(number.size)
        # a place where the model is badly off must not set the price of what lies elsewhere
        size = np.add.reduceat(rest**2, blocks.starts[:-1]) / np.diff(blocks.starts)
        freed = freed * np.sqrt(np.minimum(1.0, criteria.LOUDEST * float(np.median(size)) / np.maximum(size, 1e-300)))
        rest = rest * np.repeat(freed, np.diff(blocks.starts))
        offsets = 0 if bank.free_offsets else energy.size
        signs = np.random.default_rng(seed).choice([-1.0, 1.0], size=(SURROGATES, offsets + blocks.recording.size))
        signs_of_blocks = signs[:, offsets:]
        single = np.add.reduceat(bank.one * rest, blocks.starts[:-1])
        table = np.zeros((blocks.recording.size, energy.size))
        table[np.arange(blocks.recording.size), blocks.recording] = single
        columns = signs_of_blocks @ bank.columns.products_by(rest, blocks.starts.tolist())
        return cls(mean, columns, signs_of_blocks @ table, signs[:, :offsets], fitted)

    def at(
        self, bank: Bank, variance: float, likeliest: float, g: FloatArray, inverse: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Products of each surrogate with all columns (SURROGATES, p), the offsets marginalised at ``variance``; and
        with the whitened one of each recording (SURROGATES, recordings).

        Where the residual is that of a fit, offsets are scaled up by what the model's own coefficients have taken of
        them (HC2, MacKinnon and White 1985). ``g`` (recordings, k): products of the ones with the model's columns.
        """
        ones, _ = bank.sums()
        weight = bank.shrunk(variance)
        sums, off = self.ones, -weight * self.ones
        if self.signs.shape[1]:
            energy = np.maximum(bank.energy, 1e-300)
            scaled = self.mean
            if self.fitted:
                leverage = np.sum((g @ inverse) * g, axis=1) / (energy * (1.0 + likeliest * energy))
                scaled = self.mean / np.sqrt(1.0 - np.clip(leverage, 0.0, MOST_LEVERAGE))
            sums = sums + self.signs * (scaled * energy)
            off = off + self.signs * (scaled * (1.0 - weight * energy))
        return self.columns + off @ ones, sums
