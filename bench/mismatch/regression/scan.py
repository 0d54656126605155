"""How much each candidate would gain beside a model, and what such a gain is worth in these very recordings.

The gain of a candidate of k columns is that of log-likelihood with everything else refitted, less what k columns gain
in noise. What the best of the whole bank gains in noise is measured on surrogates: the model's residual with the signs
of its blocks, and of the recordings' offsets, drawn at random (Hemerik, Goeman and Finos, J. R. Stat. Soc. B 82
(2020) 841, for scores; Westfall and Young 1993 for the maximum). Only products with y change, so hundreds of them are
cheap.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.bank import RIDGE, Bank
from bench.simulation.frame import FloatArray, IntArray

SURROGATES = 300
MOST_LEVERAGE = 0.95
LEAST_OWN = 1e-4
"""share of a column's energy beside the model, below which the model says it all"""


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
        own = float(np.quantile(self.surrogate, 1.0 - criteria.ERROR_RATE_OF_A_CHANNEL))
        return max(tail(self.surrogate, criteria.ERROR_RATE_OF_A_CHANNEL), own)

    def p_value(self, gain: float) -> float:
        """Chance that the best of the whole bank gains as much in noise."""
        if not np.isfinite(self.surrogate).all():
            return 1.0
        return tail_probability(self.surrogate, gain)


def tail(values: FloatArray, rate: float) -> float:
    """Value exceeded at a small ``rate``, by a Gumbel law fitted to a sample of maxima."""
    place, scale = _gumbel(values)
    return float(place - scale * np.log(-np.log1p(-rate)))


def tail_probability(values: FloatArray, value: float, least: float = criteria.LEAST_P) -> float:
    """Chance that a maximum like those sampled exceeds ``value``: their share (Davison and Hinkley 1997, eq. 4.11),
    beyond the largest of them by a Gumbel law.
    """
    above = float(np.sum(values >= value))
    if above > 0.0:
        return (1.0 + above) / (1.0 + values.size)
    place, scale = _gumbel(values)
    beyond = float(-np.expm1(-np.exp(-min((value - place) / scale, 700.0))))
    return float(np.clip(beyond, least, 1.0 / (1.0 + values.size)))


def _gumbel(values: FloatArray) -> tuple[float, float]:
    """Place and scale of a Gumbel law through a sample's L-moments (Hosking, J. R. Stat. Soc. B 52 (1990) 105)."""
    ordered = np.sort(values)
    n = ordered.size
    second = float(np.sum((2.0 * np.arange(1, n + 1) - n - 1.0) * ordered) / (n * (n - 1.0)))
    scale = max(second / np.log(2.0), 1e-12)
    return float(ordered.mean()) - 0.5772156649 * scale, scale


def tail_rate(values: FloatArray, reached: float) -> float:
    """Rate at which maxima exceed a value, by the same law."""
    low, high = tail(values, 0.5), tail(values, 0.01)
    scale = max((high - low) / (np.log(-np.log1p(-0.5)) - np.log(-np.log1p(-0.01))), 1e-12)
    place = low + scale * np.log(-np.log1p(-0.5))
    return max(float(-np.expm1(-np.exp(-(reached - place) / scale))), criteria.LEAST_P)


@dataclass(frozen=True, slots=True)
class Units:
    """Blocks of rows whose signs are drawn: first row of each (blocks + 1,), and the recording each is in."""

    starts: IntArray
    recording: IntArray


def units(elapsed: FloatArray, starts: IntArray, duration: float) -> Units:
    """Cut recordings (first rows ``starts``) into blocks of about ``duration`` s."""
    first: list[int] = []
    owner: list[int] = []
    for r, (a, b) in enumerate(itertools.pairwise(starts)):
        span = float(elapsed[b - 1] - elapsed[a])
        number = max(1, round(span / duration))
        edges = np.searchsorted(elapsed[a:b], elapsed[a] + span * np.arange(number) / number) + a
        edges = np.unique(edges)
        first += [int(e) for e in edges]
        owner += [r] * edges.size
    return Units(np.array([*first, int(starts[-1])], dtype=np.int64), np.array(owner, dtype=np.int64))


def whole(blocks: Units) -> Units:
    """One unit a recording."""
    first = np.flatnonzero(np.diff(blocks.recording, prepend=-1))
    return Units(np.append(blocks.starts[:-1][first], blocks.starts[-1]), blocks.recording[first])


def scan(
    bank: Bank,
    index: Sequence[int],
    precision: FloatArray,
    variance: float,
    residual: FloatArray,
    candidates: Sequence[tuple[int, ...]],
    extra: FloatArray,
    blocks: Units,
    seed: int,
    shuffled: bool,
    least: float = LEAST_OWN,
) -> Scan:
    """Scan ``candidates`` (numbers of their columns) beside the model of the columns ``index``.

    ``precision`` (k,) of the model's coefficients; ``variance`` of the offsets; ``residual`` (n,) whitened, of the
    model; ``extra`` (m,) parameters that a candidate has beyond its columns. Surrogates are the residual itself with
    its signs drawn (``shuffled``), which is right where nothing is left in it but noise; else noise as the model has
    it.
    """
    base = list(index)
    columns, ones, _ = bank.all()
    weight = bank.shrunk(variance)
    g = ones[:, base]
    cross = bank.cross(base) - (ones * weight[:, None]).T @ g
    gram = cross[base] + np.diag(precision)
    scale = np.sqrt(np.where(np.diag(gram) > 1e-200, np.diag(gram), 1.0))
    inverse = np.linalg.inv(gram / np.outer(scale, scale) + RIDGE * np.eye(len(base))) / np.outer(scale, scale)
    away = cross @ inverse
    # the model's residual has nothing of the model's own columns left: no large numbers cancel here
    mean = bank.whitening.by_recording(bank.one * residual)
    net = columns.T @ residual - ones.T @ (weight * mean)

    drawn_from = residual if shuffled else _noise(bank, variance, seed)
    pieces = _pieces(bank, columns, ones, drawn_from, variance, blocks, g, inverse, shuffled)
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], size=(SURROGATES, pieces.shape[0]))
    drawn = signs @ pieces
    drawn = drawn - drawn[:, base] @ away.T

    gain = np.full(len(candidates), -np.inf)
    best = np.full(SURROGATES, -np.inf)
    sizes = np.array([len(c) for c in candidates])
    for k in np.unique(sizes):
        members = np.flatnonzero(sizes == k)
        places = np.array([candidates[int(m)] for m in members])
        own = np.stack([bank.own(candidates[int(m)]) for m in members])
        offsets = ones[:, places]
        full = own - np.einsum("rmk,r,rml->mkl", offsets, weight, offsets)
        left = full - np.einsum("mkb,mlb->mkl", away[places], cross[places])
        energy = np.einsum("mkk->mk", own)
        unit = np.sqrt(np.maximum(energy, 1e-300))
        scaled = left / unit[:, :, None] / unit[:, None, :]
        alive = np.einsum("mkk->mk", scaled).max(axis=1) > least
        ridge = np.maximum(1e-6 * np.einsum("mkk->m", scaled) / k, least * 1e-2)
        solved = np.linalg.inv(scaled + ridge[:, None, None] * np.eye(k))
        mine = net[places] / unit
        likelihood = 0.5 * np.einsum("mk,mkl,ml->m", mine, solved, mine)
        null = drawn[:, places] / unit
        noise = 0.5 * np.einsum("smk,mkl,sml->sm", null, solved, null)
        # what its columns gain in these surrogates on the average, twice: once fitted, once more when predicted
        price = 2.0 * np.maximum(noise.mean(axis=0), 0.5 * k) + extra[members]
        gain[members] = np.where(alive, likelihood - price, -np.inf)
        best = np.maximum(best, np.where(alive, noise - price, -np.inf).max(axis=1))
    return Scan(gain, best)


def _noise(bank: Bank, variance: float, seed: int) -> FloatArray:
    """Whitened noise (n,) as the model has it: independent rows, and an offset of each recording."""
    rng = np.random.default_rng([seed, 1])
    out = rng.normal(size=bank.y.size)
    if not np.isinf(variance):
        offset = rng.normal(size=bank.energy.size) * np.sqrt(variance)
        out += np.repeat(offset, np.diff(bank.whitening.starts)) * bank.one
    return out


def _pieces(
    bank: Bank,
    columns: FloatArray,
    ones: FloatArray,
    residual: FloatArray,
    variance: float,
    blocks: Units,
    g: FloatArray,
    inverse: FloatArray,
    fitted: bool,
) -> FloatArray:
    """Products of the columns with each unit's part of the residual (units, p), the offsets marginalised.

    Units are the recordings' offsets, then the blocks of what is left. Where the residual is that of a fit, offsets are
    scaled up by what the model's own coefficients have taken of them (HC2, MacKinnon and White 1985).
    """
    energy = np.maximum(bank.energy, 1e-300)
    mean = bank.whitening.by_recording(bank.one * residual) / energy
    rest = residual - np.repeat(mean, np.diff(bank.whitening.starts)) * bank.one
    weight = bank.shrunk(variance)
    out = []
    if not np.isinf(variance):
        share = energy * (1.0 + variance * energy)
        leverage = np.einsum("rk,kl,rl->r", g, inverse, g) / share
        scaled = mean / np.sqrt(1.0 - np.clip(leverage, 0.0, MOST_LEVERAGE)) if fitted else mean
        out.append(ones * (scaled * (1.0 - weight * energy))[:, None])
    own = np.empty((blocks.recording.size, columns.shape[1]))
    # what is left has lost its mean in each recording: a degree of freedom of as many as it has blocks
    number = np.bincount(blocks.recording)[blocks.recording].astype(np.float64)
    freed = np.sqrt(number / np.maximum(number - 1.0, 0.5)) if fitted else np.ones(number.size)
    # a place where the model is badly off must not set the price of what lies elsewhere
    size = np.add.reduceat(rest**2, blocks.starts[:-1]) / np.diff(blocks.starts)
    freed = freed * np.sqrt(np.minimum(1.0, criteria.LOUDEST * float(np.median(size)) / np.maximum(size, 1e-300)))
    for b in range(blocks.recording.size):
        rows = slice(blocks.starts[b], blocks.starts[b + 1])
        part = rest[rows] * freed[b]
        own[b] = part @ columns[rows]
        own[b] -= weight[blocks.recording[b]] * float(bank.one[rows] @ part) * ones[blocks.recording[b]]
    out.append(own)
    return np.vstack(out)
