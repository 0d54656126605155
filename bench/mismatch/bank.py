"""A bank of regressors of one channel, and the predictive score of any model drawn from it.

All columns that may enter a model (the calibrated simulation, every form of every term at every grid point, free-form
rivals) are whitened once. A model is then a set of columns, and its score costs a solve of the size of what a candidate
adds: candidates are always refitted jointly with everything else, and every gain is measured on recordings that the
coefficients have not seen (leave one fold out).

Noise: independent rows of standard deviation ``sigma``, correlated with their neighbour, and an unknown offset a
recording of variance v, marginalised in closed form: G - v/(1 + v*e) * g g', with g the columns' products with the
whitened one, and e its energy.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.products import Products
from bench.simulation.frame import FloatArray, IntArray

RIDGE = 1e-9
"""relative to each column's own energy: keeps absent columns (a speed never driven) from breaking the solve"""
_KEPT = 48
"""eliminations that are remembered: those of some variances of the few sets of columns in work"""
_CHUNK = 64
"""columns whitened at once"""


@dataclass(frozen=True, slots=True)
class Noise:
    """Noise of the rows of a channel."""

    sigma: FloatArray
    """standard deviation a row"""
    correlation: FloatArray
    """correlation of each row with the one before"""
    offset_variances: tuple[float, ...] = (0.0,)
    """variances of the recordings' offsets that are tried; (inf,) makes the offsets free"""


@dataclass(frozen=True, slots=True)
class Fit:
    """A model's coefficients and score. ``likelihood`` has one predictive log-likelihood a fold (up to a constant), or
    one number for all rows where no fold was left out; only then is there a ``covariance`` of the coefficients.
    """

    likelihood: FloatArray
    coefficients: FloatArray
    covariance: FloatArray
    offset_variance: float

    @property
    def total(self) -> float:
        """Predictive log-likelihood of all folds."""
        return float(self.likelihood.sum())


def whiten(columns: FloatArray, noise: Noise, starts: IntArray) -> FloatArray:
    """Unit variance and no correlation between neighbours; rows (n, k), ``starts`` (recordings + 1,)."""
    scaled = columns / noise.sigma[:, None]
    before = np.vstack([np.zeros((1, scaled.shape[1])), scaled[:-1]])
    rho = noise.correlation.copy()
    rho[starts[:-1]] = 0.0
    return np.asarray((scaled - rho[:, None] * before) / np.sqrt(1.0 - rho**2)[:, None])


@dataclass(frozen=True, slots=True)
class _Eliminated:
    """Columns that many models share, eliminated once in every fold left out: others = L·Lᵀ."""

    inverse: FloatArray
    """L⁻¹ (folds, g, g)"""
    solved: FloatArray
    """L⁻¹ times the right-hand side (folds, g)"""
    logarithm: FloatArray
    """logarithm of the determinant (folds,)"""
    total: FloatArray
    """Gram matrix of all folds (g, g), in the columns' own units"""


class Bank:
    """Scores of models over whitened columns.

    Parameters: ``y`` (n,); ``starts`` (recordings + 1,) row ranges; ``folds`` (recordings,) fold of each recording;
    ``columns`` (n, p) everything that may enter; ``prior`` (p,) prior precision of each coefficient relative to the
    column's energy (0: flat); ``precision`` (p,) prior precision in the coefficient's own unit. ``spend``: the bank may
    whiten ``columns`` in their place, whose raw values are then gone (they are the largest thing a comparison holds).
    """

    def __init__(
        self,
        y: FloatArray,
        starts: IntArray,
        folds: IntArray,
        columns: FloatArray,
        prior: FloatArray,
        noise: Noise,
        precision: FloatArray | None = None,
        spend: bool = False,
    ) -> None:
        self.size = columns.shape[1]
        self.starts, self.noise, self.prior = starts, noise, prior
        self._precision = np.zeros(self.size) if precision is None else precision
        white = columns if spend else np.empty(columns.shape, order="F")
        for a in range(0, self.size, _CHUNK):
            white[:, a : a + _CHUNK] = whiten(columns[:, a : a + _CHUNK], noise, starts)
        own = whiten(np.column_stack([y, np.ones_like(y)]), noise, starts)
        self._products = Products(white, own[:, 0], own[:, 1], starts, folds)
        self._eliminated: dict[tuple[tuple[int, ...], float], _Eliminated] = {}
        self._likeliest: int | None = None
        self._known_as: dict[int, int] | None = None

    @property
    def precision(self) -> FloatArray:
        """Prior precision of each coefficient in its own unit (p,)."""
        return self._precision

    @precision.setter
    def precision(self, values: FloatArray) -> None:
        self._precision = values
        self._eliminated = {}

    def narrowed(self, index: Sequence[int]) -> Bank:
        """A bank of some columns only: cheap to fit, and to replace columns in, without touching this one."""
        out = object.__new__(Bank)
        place = list(index)
        out.size = len(place)
        out.starts, out.noise = self.starts, self.noise
        out.prior, out._precision = self.prior[place], self.precision[place]
        out._products = self._products.narrowed(place)
        out._eliminated, out._known_as, out._likeliest = {}, None, self._likeliest
        return out

    def only(self, index: Collection[int]) -> Bank:
        """A bank that goes on fitting models of some columns, under their numbers, and has let go of all others."""
        place = sorted(index)
        out = self.narrowed(place)
        out._products.close()
        out._known_as = {column: k for k, column in enumerate(place)}
        return out

    def _own_numbers(self, index: Sequence[int] | NDArray[np.int64]) -> list[int]:
        return [int(i) if self._known_as is None else self._known_as[int(i)] for i in index]

    def replace(self, index: Sequence[int], columns: FloatArray) -> None:
        """Put other columns in the place of some (to refine a nonlinear parameter)."""
        self._products.replace(index, whiten(columns, self.noise, self.starts))
        gone = set(index)
        self._eliminated = {key: value for key, value in self._eliminated.items() if not gone & set(key[0])}

    def marginal(self, index: Sequence[int] | NDArray[np.int64], variance: float) -> tuple[FloatArray, FloatArray]:
        """Gram matrices a fold of the columns chosen (and y), the offsets marginalised; their log-determinants."""
        keep = [*self._own_numbers(index), self.size]
        return self._products.marginal(keep, keep, variance), self._products.cost(variance)

    def fit(self, index: Sequence[int] | NDArray[np.int64], leave_out: bool = True) -> Fit:
        """Fit the columns ``index`` and score the folds, each predicted by the others (or all by all).

        Raises numpy.linalg.LinAlgError only where columns are not finite.
        """
        chosen = self._own_numbers(index)
        variances = self.noise.offset_variances
        tried: dict[int, Fit] = {}

        def at(number: int) -> float:
            if number not in tried:
                tried[number] = (self._left_out if leave_out else self._all)(chosen, variances[number])
            return tried[number].total

        if self._likeliest is None:
            self._likeliest = max(range(len(variances)), key=at)
        # from the variance that was likeliest last, uphill: a column that explains offsets leaves a far smaller one
        while True:
            here = self._likeliest
            near = range(max(0, here - 1), min(len(variances), here + 2))
            self._likeliest = max(near, key=lambda number: (at(number), number == here))
            if self._likeliest == here:
                return tried[here]

    def _penalty(self, chosen: list[int], scale: FloatArray) -> FloatArray:
        """Prior precisions of scaled coefficients (k,)."""
        return np.asarray(self.prior[chosen] + RIDGE + self.precision[chosen] / scale**2)

    def _all(self, chosen: list[int], variance: float) -> Fit:
        """All rows by all rows."""
        keep = [*chosen, self.size]
        gram, cost = self._products.marginal(keep, keep, variance), self._products.cost(variance)
        total, p = gram.sum(axis=0), len(chosen)
        if p == 0:
            return Fit(-0.5 * (total[0] + cost.sum()), np.zeros(0), np.zeros((0, 0)), variance)
        scale = _scale(np.diag(total)[:p])
        own, right = total[:p, :p] / np.outer(scale, scale), total[:p, p] / scale
        inverse = np.linalg.inv(own + np.diag(self._penalty(chosen, scale)))
        beta = inverse @ right
        squares = total[p, p] + beta @ own @ beta - 2.0 * beta @ right
        return Fit(np.array([-0.5 * (squares + cost.sum())]), beta / scale, inverse / np.outer(scale, scale), variance)

    def _left_out(self, chosen: list[int], variance: float) -> Fit:
        """Each fold by the others: what many models share is eliminated once, a candidate then costs its own size."""
        products, y = self._products, self.size
        cost = products.cost(variance)
        squares = products.marginal([y], [y], variance)[:, 0, 0]
        if not chosen:
            return Fit(-0.5 * (squares + cost), np.zeros(0), np.zeros((0, 0)), variance)
        shared, own = products.parted(chosen)
        held = self._elimination(tuple(shared), variance)
        g = len(shared)
        across = products.marginal(shared, own, variance)
        inside = products.marginal(own, own, variance)
        mine = products.marginal([y], [*shared, *own], variance)[:, 0]
        total = np.block([[held.total, across.sum(axis=0)], [across.sum(axis=0).T, inside.sum(axis=0)]])
        scale = _scale(np.diag(total))
        normal = total / np.outer(scale, scale) + np.diag(self._penalty([*shared, *own], scale))
        mine = mine / scale
        right = mine.sum(axis=0)
        mixed = scale[:g, None] * scale[g:]
        between = held.inverse @ (normal[:g, g:] - across / mixed)
        schur = normal[g:, g:] - inside / np.outer(scale[g:], scale[g:]) - np.swapaxes(between, 1, 2) @ between
        target = right[g:] - mine[:, g:] - np.einsum("fgk,fg->fk", between, held.solved)
        tail = np.linalg.solve(schur, target[..., None])[..., 0]
        head = np.einsum("fgh,fg->fh", held.inverse, held.solved - np.einsum("fgk,fk->fg", between, tail))
        beta = np.hstack([head, tail])
        coefficients = np.linalg.solve(normal, right)
        # predictive density of the fold: its own rows tell the coefficients, too; the others know them only so well.
        # With others·beta = right - mine every term of it can be said with the common normal matrix
        moved = beta @ normal
        apart = coefficients - beta
        squares = squares - np.einsum("fk,fk->f", apart, right - moved)
        squares += np.einsum("fk,fk->f", beta, moved - right - mine)
        cost = cost + np.linalg.slogdet(normal)[1] - held.logarithm - np.linalg.slogdet(schur)[1]
        place = _places([*shared, *own], chosen)
        return Fit(-0.5 * (squares + cost), (coefficients / scale)[place], np.zeros((0, 0)), variance)

    def _elimination(self, shared: tuple[int, ...], variance: float) -> _Eliminated:
        key = (shared, variance)
        if key not in self._eliminated:
            if len(self._eliminated) >= _KEPT:
                self._eliminated.pop(next(iter(self._eliminated)))
            keep = list(shared)
            gram = self._products.marginal(keep, keep, variance)
            mine = self._products.marginal([self.size], keep, variance)[:, 0]
            total = gram.sum(axis=0)
            scale = _scale(np.diag(total))
            outer = np.outer(scale, scale)
            normal = total / outer + np.diag(self._penalty(keep, scale))
            lower = np.linalg.cholesky(normal - gram / outer)
            inverse = np.linalg.inv(lower)
            right = (mine.sum(axis=0) - mine) / scale
            logarithm = 2.0 * np.log(np.diagonal(lower, axis1=1, axis2=2)).sum(axis=1)
            self._eliminated[key] = _Eliminated(inverse, np.einsum("fgh,fh->fg", inverse, right), logarithm, total)
        return self._eliminated[key]

    def beside(self, columns: FloatArray, index: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """What of further ``columns`` (n, k) the columns ``index`` cannot produce: Gram matrix (k, k), products with y
        (k,), in units of the noise, the offsets marginalised at their likeliest.

        A combination s of them gains (s·h)²/(2·s·H·s) of log-likelihood.
        """
        variance = self.fit(index, leave_out=False).offset_variance
        keep = [*self._own_numbers(index), self.size]
        gram, cross = self._products.beside(whiten(columns, self.noise, self.starts), keep, variance)
        total = self._products.marginal(keep, keep, variance).sum(axis=0)
        p = len(keep) - 1
        scale = _scale(np.diag(total)[:p])
        normal = total[:p, :p] / np.outer(scale, scale) + np.diag(self._penalty(keep[:-1], scale))
        solved = np.linalg.solve(normal, np.column_stack([cross[:p], total[:p, p]]) / scale[:, None])
        away = (cross[:p] / scale[:, None]).T @ solved
        return gram - away[:, :-1], cross[p] - away[:, -1]

    def explained(self, index: Sequence[int], base: Sequence[int]) -> float:
        """Share of the columns' energy that ``base`` cannot produce (1: orthogonal to it, 0: absorbed)."""
        gram, _ = self.marginal([*base, *index], self.noise.offset_variances[-1])
        total = gram.sum(axis=0)[:-1, :-1]
        b = len(base)
        inner = total[:b, :b] + np.diag(np.diag(total)[:b] * 1e-9 + 1e-300)
        left = total[b:, b:] - total[b:, :b] @ np.linalg.solve(inner, total[:b, b:])
        return float(np.trace(left) / max(np.trace(total[b:, b:]), 1e-300))


def _scale(energy: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.where(energy > 1e-200, energy, 1.0)))


def _places(of: list[int], wanted: list[int]) -> list[int]:
    where = {column: k for k, column in enumerate(of)}
    return [where[column] for column in wanted]
