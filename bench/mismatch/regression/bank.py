"""A bank of regressors of one channel, whitened once, and the products that every model of them needs.

Rows are whitened by their noise (:mod:`bench.mismatch.regression.noise`); an offset a recording of variance v is
marginalised in closed form: G - w*g*g' with g the columns' products with the whitened one of the recording, e its
energy, w = v/(1 + v*e). So models for any v, candidates by the hundred and surrogates of the recordings cost products
of small matrices only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtrs
from scipy.stats import chi2

from bench.mismatch.regression.kept import Kept
from bench.mismatch.regression.noise import RowNoise
from bench.simulation.frame import FloatArray, IntArray

RIDGE = 1e-9
"""relative to a column's own energy: keeps absent columns (a speed never driven) from breaking a solve"""
FEWEST_FREE = 6
"""recordings beyond a model's numbers below which their means do not bound the offsets"""
LADDER = (0.0, *(float(v) for v in np.geomspace(0.1, 3e7, 35)))
"""variances of the offsets that are tried, over the variance that noise gives a recording's mean"""


@dataclass(frozen=True, slots=True)
class Whitening:
    """Makes rows of unit variance without correlation; ``starts`` (recordings + 1,) are the recordings' first rows."""

    noise: RowNoise
    starts: IntArray

    def apply(self, columns: FloatArray) -> FloatArray:
        """Whiten columns (n, k) or one (n,)."""
        flat = columns.ndim == 1
        scaled = (columns[:, None] if flat else columns) / self.noise.sigma[:, None]
        rho = self.noise.correlation.copy()
        rho[self.starts[:-1]] = 0.0
        out = scaled.copy()
        out[1:] -= rho[1:, None] * scaled[:-1]
        out /= np.sqrt(1.0 - rho**2)[:, None]
        return np.asarray(out[:, 0] if flat else out)

    def by_recording(self, values: FloatArray) -> FloatArray:
        """Sums over the rows of each recording (recordings, k)."""
        return np.asarray(np.add.reduceat(values, self.starts[:-1], axis=0))


@dataclass(frozen=True, slots=True)
class Normal:
    """Normal equations of some columns with the offsets marginalised: Gram matrix (k, k), right side (k,), squares of
    y, logarithm of the offsets' determinant.
    """

    gram: FloatArray
    right: FloatArray
    squares: float
    cost: float


class Bank:
    """Whitened columns, their products with a few that stand in models, and with y.

    ``y`` (n,); ``free_offsets``: the offsets have no prior (their variance is infinite).
    """

    def __init__(self, y: FloatArray, whitening: Whitening, free_offsets: bool = False) -> None:
        self.whitening = whitening
        self.y = whitening.apply(y)
        self.one = whitening.apply(np.ones(y.size))
        self.energy = whitening.by_recording(self.one**2)
        self.free_offsets = free_offsets
        self.columns = Kept(y.size)
        self._sums = np.zeros((self.energy.size, 0)), np.zeros(0)
        self._block_grams: dict[tuple[int, int], FloatArray] = {}
        self._cross: dict[int, FloatArray] = {}
        self.likeliest = len(LADDER) // 2
        """place on the ladder of the variance that was likeliest last"""
        self.most = np.inf
        """variance of the offsets above which none is tried"""
        self._bounds: dict[tuple[int, ...], float] = {}
        self._one_y = whitening.by_recording(self.one * self.y)
        self._squares = float(self.y @ self.y)

    @property
    def size(self) -> int:
        """Number of columns."""
        return self.columns.size

    def add(self, columns: FloatArray) -> tuple[int, ...]:
        """Whiten columns (n, k) and keep them; returns their numbers."""
        white = self.whitening.apply(np.where(np.isfinite(columns), columns, 0.0))
        indices = tuple(range(self.size, self.size + white.shape[1]))
        self.columns.add(white)
        return indices

    def sums(self) -> tuple[FloatArray, FloatArray]:
        """Products of all columns with the ones of each recording (recordings, p), and with y (p,)."""
        ones, right = self._sums
        if right.size < self.size:
            further = self.columns.products_by(self.one, self.whitening.starts.tolist(), right.size)
            with_y = self.columns.products(self.y, right.size)
            self._sums = np.hstack([ones, further]), np.concatenate([right, with_y])
        return self._sums

    def variances(self) -> tuple[float, ...]:
        """Variances of the offsets to try; infinite alone where they are free."""
        if self.free_offsets:
            return (np.inf,)
        unit = 1.0 / max(float(np.median(self.energy)), 1e-300)
        return tuple(unit * share for share in LADDER if share <= LADDER[1] or unit * share <= self.most)

    def bound_offsets(self, index: Sequence[int], chance: float) -> None:
        """Try no variance of the offsets which the recordings' means rule out at a ``chance``: what columns ``index``
        leave of the means, each fitted as the means alone would have it, holds the offsets and noise.

        What a model lacks inside the recordings may pull its coefficients away from what fits the means, and offsets of
        any size would take the difference. Nothing is ruled out where the means are few.
        """
        bound = self._bound(index, chance)
        if np.isfinite(bound):
            self.most = bound

    def ruled_in(self, variances: Sequence[float], index: Sequence[int], chance: float) -> tuple[float, ...]:
        """Those of the offsets' ``variances`` (ascending, the first always) that the recordings' means do not rule out
        for columns ``index``; see :meth:`bound_offsets`.
        """
        key = tuple(index)
        if key not in self._bounds:
            self._bounds[key] = self._bound(index, chance)
        return (variances[0], *(v for v in variances[1:] if v <= self._bounds[key]))

    def _bound(self, index: Sequence[int], chance: float) -> float:
        """The largest variance that the means allow; infinite where they are few."""
        least, free = _least_squares(*self._means(index))
        return least / float(chi2.ppf(chance, free)) if free >= FEWEST_FREE else np.inf

    def contradicted(self, index: Sequence[int], coefficients: FloatArray, chance: float) -> bool:
        """Whether coefficients of columns ``index`` leave more of the recordings' means than chance explains beside
        what the same columns leave of them when fitted to the means alone.

        Then what is inside the recordings has pulled them away: something acts there that the columns cannot say, and
        rows that share it were taken for as many independent readings.
        """
        mean, y = self._means(index)
        least, free = _least_squares(mean, y)
        if free < FEWEST_FREE:
            return False
        largest = least / float(chi2.ppf(chance, free)) * float(chi2.isf(chance, y.size))
        return float(np.sum((y - mean @ coefficients) ** 2)) > largest

    def _means(self, index: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """Mean of some columns and of y in each recording (recordings, k), (recordings,)."""
        ones, _ = self.sums()
        driven = self.energy > 0.0
        return ones[driven][:, list(index)] / self.energy[driven, None], self._one_y[driven] / self.energy[driven]

    def shrunk(self, variance: float) -> FloatArray:
        """What of each recording's mean its offset takes, over its energy (recordings,)."""
        if np.isinf(variance):
            return np.asarray(np.where(self.energy > 0, 1.0 / np.maximum(self.energy, 1e-300), 0.0))
        return np.asarray(variance / (1.0 + variance * self.energy))

    def less_offsets(self, white: FloatArray, variance: float) -> FloatArray:
        """Whitened columns (n, k) or one (n,) less so much of each recording's mean that their products are those with
        the offsets marginalised.
        """
        columns = white[:, None] if white.ndim == 1 else white
        energy = np.maximum(self.energy, 1e-300)
        share = np.ones(energy.size) if np.isinf(variance) else 1.0 - 1.0 / np.sqrt(1.0 + variance * energy)
        mean = self.whitening.by_recording(self.one[:, None] * columns) * (share / energy)[:, None]
        out = columns - np.repeat(mean, np.diff(self.whitening.starts), axis=0) * self.one[:, None]
        return np.asarray(out[:, 0] if white.ndim == 1 else out)

    def cost(self, variance: float) -> float:
        """Logarithm of the determinant of the offsets' covariance."""
        return 0.0 if np.isinf(variance) else float(np.sum(np.log1p(variance * self.energy)))

    def _crossed(self, index: Sequence[int], whole: bool) -> None:
        """Make the products of some columns with all columns, where they are not made yet; ``whole``: with those too
        that have come since.
        """
        for known in {self._cross[i].size if i in self._cross else 0 for i in index} - {self.size}:
            if known and not whole:
                continue
            fresh = [i for i in dict.fromkeys(index) if (self._cross[i].size if i in self._cross else 0) == known]
            further = self.columns.products(self.columns.some(fresh), known)
            for k, i in enumerate(fresh):
                before = [self._cross[i]] if known else []
                self._cross[i] = np.concatenate([*before, further[:, k]])

    def cross(self, index: Sequence[int]) -> FloatArray:
        """Products of all columns with some, (p, k), without offsets."""
        self._crossed(index, True)
        return np.column_stack([self._cross[i] for i in index]) if index else np.zeros((self.size, 0))

    def block_gram(self, columns: tuple[int, ...]) -> FloatArray:
        """Products of a few columns that were added together among themselves (k, k), without offsets."""
        key = (columns[0], columns[-1])
        if key not in self._block_grams:
            part = self.columns.some(columns)
            self._block_grams[key] = part.T @ part
        return self._block_grams[key]

    def gram(self, index: Sequence[int]) -> FloatArray:
        """Products of some columns among themselves (k, k), without offsets."""
        chosen = np.asarray(index, dtype=np.int64)
        out = np.empty((chosen.size, chosen.size))
        # most columns that are tried are tried once: they are not multiplied with the whole bank
        fresh = [k for k, i in enumerate(index) if i not in self._cross]
        if fresh:
            part = self.columns.some(index)
            out[:, fresh] = part.T @ part[:, fresh]
            out[fresh] = out[:, fresh].T
        for k, i in enumerate(index):
            if i not in self._cross:
                continue
            row = self._cross[i]
            # of two columns the one whose products were made last knows the other
            known = chosen < row.size
            out[k, known] = row[chosen[known]]
            out[known, k] = out[k, known]
        return out

    def normal(self, index: Sequence[int], variance: float, gram: FloatArray | None = None) -> Normal:
        """Normal equations of the columns ``index`` for a variance of the offsets; ``gram``: their products, if they
        are known.
        """
        chosen = list(index)
        ones, right = self.sums()
        weight = self.shrunk(variance)
        g = ones[:, chosen]
        inner = (self.gram(chosen) if gram is None else gram) - (weight[:, None] * g).T @ g
        right_side = right[chosen] - g.T @ (weight * self._one_y)
        squares = self._squares - float(np.sum(weight * self._one_y**2))
        return Normal(0.5 * (inner + inner.T), right_side, squares, self.cost(variance))

    def close(self, index: Sequence[int]) -> None:
        """Let go of all columns: from now on only columns ``index`` can be fitted, by their products."""
        self._crossed(index, False)
        self.sums()
        self._block_grams.clear()
        self._cross = {i: self._cross[i] for i in dict.fromkeys(index)}
        self.columns.clear()

    def residual(self, index: Sequence[int], coefficients: FloatArray) -> FloatArray:
        """Whitened residual (n,) of a model; the recordings' offsets are left in it."""
        return np.asarray(self.y - self.columns.some(index) @ coefficients)

    def levels(self, residual: FloatArray) -> FloatArray:
        """Mean of a whitened residual (n,) in each recording (recordings,), before it was whitened."""
        return np.asarray(self.whitening.by_recording(self.one * residual) / np.maximum(self.energy, 1e-300))

    def about_levels(self, residual: FloatArray) -> FloatArray:
        """A whitened residual (n,) less the mean of each recording."""
        return np.asarray(residual - np.repeat(self.levels(residual), np.diff(self.whitening.starts)) * self.one)


def _least_squares(columns: FloatArray, y: FloatArray) -> tuple[float, int]:
    """Squares that columns (n, k) leave of y (n,), and the degrees of freedom."""
    scale = np.maximum(np.sqrt(np.mean(columns**2, axis=0)), 1e-300)
    found, _, rank, _ = np.linalg.lstsq(columns / scale, y, rcond=RIDGE)
    return float(np.sum((y - columns / scale @ found) ** 2)), y.size - int(rank)


@dataclass(frozen=True, slots=True)
class Fit:
    """Coefficients (k,) of a model with their covariance (k, k), the offsets' variance, and its log-likelihood;
    ``spread``: the offsets' variance that is the likeliest whatever the coefficients are. What these take of the
    offsets is no evidence that offsets are small (Patterson and Thompson, Biometrika 58 (1971) 545).
    """

    index: tuple[int, ...]
    coefficients: FloatArray
    covariance: FloatArray
    variance: float
    likelihood: float
    spread: float

    def of(self, columns: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """Coefficients and covariance of some columns."""
        positions = [self.index.index(i) for i in columns]
        return self.coefficients[positions], self.covariance[np.ix_(positions, positions)]


def solve(normal: Normal, precision: FloatArray | float = 0.0) -> tuple[FloatArray, FloatArray, float]:
    """Coefficients, covariance and log-likelihood (offsets marginalised, coefficients at their best) of a model.

    ``precision`` (k,): prior precision of each coefficient in its own unit.
    """
    k = normal.right.size
    if k == 0:
        return np.zeros(0), np.zeros((0, 0)), -0.5 * (normal.squares + normal.cost)
    scale, scaled = _scaled(normal, precision)
    inverse = np.linalg.inv(scaled)
    right = normal.right / scale
    beta = inverse @ right
    squares = normal.squares - float(beta @ right)
    return beta / scale, inverse / np.outer(scale, scale), -0.5 * (squares + normal.cost)


def _scaled(normal: Normal, precision: FloatArray | float) -> tuple[FloatArray, FloatArray]:
    """Size of each column (k,), and the normal equations of columns of size 1 with the prior in them (k, k)."""
    diagonal = np.diagonal(normal.gram)
    scale = np.sqrt(np.where(diagonal > 1e-200, diagonal, 1.0))
    scaled = normal.gram / scale[:, None] / scale
    prior = np.broadcast_to(np.asarray(precision, dtype=np.float64), scale.shape) / scale**2 + RIDGE
    scaled[np.diag_indices_from(scaled)] += prior
    return scale, scaled


def _likelihoods(normal: Normal, precision: FloatArray | float) -> tuple[float, float]:
    """Log-likelihood of :func:`solve`, and half the logarithm of the determinant of its covariance: what of it the
    coefficients take. One factor says both, where neither coefficients nor covariance are asked for.
    """
    if normal.right.size == 0:
        return -0.5 * (normal.squares + normal.cost), 0.0
    scale, scaled = _scaled(normal, precision)
    lower, failed = dpotrf(scaled, lower=True)
    if failed:  # columns so alike that rounding decides
        _, covariance, likelihood = solve(normal, precision)
        return likelihood, 0.5 * float(np.linalg.slogdet(covariance)[1])
    half = dtrtrs(lower, normal.right / scale, lower=True)[0]
    squares = normal.squares - float(half @ half)
    taken = -float(np.sum(np.log(np.diagonal(lower)))) - float(np.sum(np.log(scale)))
    return -0.5 * (squares + normal.cost), taken


def likelihood_at(bank: Bank, index: Sequence[int], variance: float, precision: FloatArray | float = 0.0) -> float:
    """Log-likelihood of the columns ``index`` for one ``variance`` of the offsets."""
    return _likelihoods(bank.normal(index, variance), precision)[0]


def fit(bank: Bank, index: Sequence[int], variances: Sequence[float], precision: FloatArray | float = 0.0) -> Fit:
    """Fit the columns ``index`` with the likeliest of the offsets' ``variances`` (ascending): uphill from the last one
    and from both ends.
    """
    tried: dict[int, tuple[float, float]] = {}
    gram = bank.gram(index)

    def at(position: int, restricted: bool) -> float:
        if position not in tried:
            likelihood, taken = _likelihoods(bank.normal(index, variances[position], gram), precision)
            tried[position] = likelihood, likelihood + taken
        return tried[position][restricted]

    def uphill(here: int, restricted: bool) -> int:
        while True:
            around = range(max(here - 1, 0), min(here + 2, len(variances)))
            best = max(around, key=lambda k: (at(k, restricted), k == here))
            if best == here:
                return here
            here = best

    def highest(restricted: bool) -> int:
        # what differs between recordings is in the offsets or in the columns: there may be a hill for each
        starts = (min(bank.likeliest, last), 0, last)
        return max((uphill(start, restricted) for start in starts), key=lambda k: at(k, restricted))

    last = len(variances) - 1
    found = bank.likeliest = highest(False)
    coefficients, covariance, likelihood = solve(bank.normal(index, variances[found], gram), precision)
    return Fit(tuple(index), coefficients, covariance, variances[found], likelihood, variances[highest(True)])
