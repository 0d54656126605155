"""A bank of regressors of one channel, and the predictive score of any model drawn from it.

All columns that may enter a model (the calibrated simulation, every form of every term at every grid point, free-form
rivals) are whitened once and their Gram matrices kept, one a fold. A model is then a set of columns, and its score
costs a solve of its own size: candidates are always refitted jointly with everything else, and every gain is measured
on recordings that the coefficients have not seen (leave one fold out).

Noise: independent rows of standard deviation ``sigma``, correlated with their neighbour, and an unknown offset a
recording of variance v, marginalised in closed form: G - v/(1 + v*e) * g g', with g the columns' products with the
whitened one, and e its energy.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.simulation.frame import FloatArray, IntArray

RIDGE = 1e-9
"""relative to each column's own energy: keeps absent columns (a speed never driven) from breaking the solve"""


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
    """A model's coefficients and score. ``likelihood`` has one predictive log-likelihood a fold (up to a constant)."""

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


class Bank:
    """Gram matrices of whitened columns.

    Parameters: ``y`` (n,); ``starts`` (recordings + 1,) row ranges; ``folds`` (recordings,) fold of each recording;
    ``columns`` (n, p) everything that may enter; ``prior`` (p,) prior precision of each coefficient relative to the
    column's energy (0: flat); ``precision`` (p,) prior precision in the coefficient's own unit.
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
    ) -> None:
        self.precision = np.zeros(columns.shape[1]) if precision is None else precision
        self.starts, self.folds, self.noise, self.prior = starts, folds, noise, prior
        self.size = columns.shape[1]
        full = whiten(np.column_stack([columns, y, np.ones_like(y)]), noise, starts)
        self._full = full
        count, p = int(folds.max()) + 1, self.size + 1
        self.gram = np.zeros((count, p, p))
        self.ones = np.zeros((folds.size, p))
        self.energy = np.zeros(folds.size)
        for r, (a, b) in enumerate(itertools.pairwise(starts)):
            part = full[a:b, :p]
            one = full[a:b, p]
            self.gram[folds[r]] += part.T @ part
            self.ones[r] = one @ part
            self.energy[r] = one @ one
        self.rows = int(y.size)
        self._likeliest: int | None = None

    def narrowed(self, index: Sequence[int]) -> Bank:
        """A bank of some columns only: cheap to fit, and to replace columns in, without touching this one."""
        place = np.asarray([*index, self.size], dtype=np.int64)
        out = copy(self)
        out.size = len(index)
        out._full = self._full[:, np.append(place, self.size + 1)]
        out.gram = self.gram[:, place[:, None], place[None, :]]
        out.ones = self.ones[:, place]
        out.prior, out.precision = self.prior[place[:-1]], self.precision[place[:-1]]
        return out

    def replace(self, index: Sequence[int], columns: FloatArray) -> None:
        """Put other columns in the place of some (to refine a nonlinear parameter)."""
        new = whiten(columns, self.noise, self.starts)
        place = list(index)
        self._full[:, place] = new
        p = self.size + 1
        self.gram[:, place, :] = 0.0
        for r, (a, b) in enumerate(zip(self.starts[:-1], self.starts[1:], strict=True)):
            part = self._full[a:b]
            self.gram[self.folds[r]][place] += new[a:b].T @ part[:, :p]
            self.ones[r, place] = part[:, p] @ new[a:b]
        self.gram[:, :, place] = np.swapaxes(self.gram[:, place, :], 1, 2)

    def marginal(self, index: NDArray[np.int64], variance: float) -> tuple[FloatArray, FloatArray]:
        """Gram matrices a fold of the columns chosen (and y), the offsets marginalised; their log-determinants."""
        keep = np.append(index, self.size)
        gram = self.gram[:, keep[:, None], keep[None, :]]
        cost = np.zeros(gram.shape[0])
        if variance == 0.0:
            return gram, cost
        if np.isinf(variance):
            factor = np.where(self.energy > 0, 1.0 / np.maximum(self.energy, 1e-300), 0.0)
        else:
            factor = variance / (1.0 + variance * self.energy)
            np.add.at(cost, self.folds, np.log1p(variance * self.energy))
        vector = self.ones[:, keep]
        outer = (factor[:, None] * vector)[:, :, None] * vector[:, None, :]
        np.subtract.at(gram, self.folds, outer)
        return gram, cost

    def fit(self, index: Sequence[int] | NDArray[np.int64], leave_out: bool = True) -> Fit:
        """Fit the columns ``index`` and score the folds, each predicted by the others (or all by all).

        Raises numpy.linalg.LinAlgError only where columns are not finite.
        """
        chosen = np.asarray(index, dtype=np.int64)
        best: Fit | None = None
        variances = self.noise.offset_variances
        near = (
            range(len(variances))
            if self._likeliest is None
            else range(max(0, self._likeliest - 1), min(len(variances), self._likeliest + 2))
        )
        for number in near:
            fit = self._fit(chosen, variances[number], leave_out)
            if best is None or fit.total > best.total:
                best, self._likeliest = fit, number
        assert best is not None
        return best

    def _fit(self, chosen: NDArray[np.int64], variance: float, leave_out: bool) -> Fit:
        gram, cost = self.marginal(chosen, variance)
        p = chosen.size
        squares = gram[:, p, p].copy()
        if p == 0:
            return Fit(-0.5 * (squares + cost), np.zeros(0), np.zeros((0, 0)), variance)
        total = gram.sum(axis=0)
        energy = np.diag(total)[:p]
        scale = np.sqrt(np.where(energy > 1e-200, energy, 1.0))
        own = gram[:, :p, :p] / scale[:, None] / scale[None, :]
        mine = gram[:, :p, p] / scale
        normal = total[:p, :p] / scale[:, None] / scale[None, :] + np.diag(
            self.prior[chosen] + RIDGE + self.precision[chosen] / scale**2
        )
        right = total[:p, p] / scale
        inverse = np.linalg.inv(normal)
        if leave_out:
            others = normal[None] - own
            beta = np.linalg.solve(others, (right[None] - mine)[..., None])[..., 0]
            # predictive density of the fold: its own rows tell the coefficients, too; the others know them only so well
            innovation = mine - np.einsum("rij,rj->ri", own, beta)
            squares -= np.einsum("ri,ij,rj->r", innovation, inverse, innovation)
            cost = cost + np.linalg.slogdet(normal)[1] - np.linalg.slogdet(others)[1]
        else:
            beta = np.broadcast_to(inverse @ right, mine.shape)
        squares += np.einsum("ri,rij,rj->r", beta, own, beta) - 2.0 * np.einsum("ri,ri->r", beta, mine)
        return Fit(
            -0.5 * (squares + cost),
            (inverse @ right) / scale,
            inverse / scale[:, None] / scale[None, :],
            variance,
        )

    def explained(self, index: Sequence[int], base: Sequence[int]) -> float:
        """Share of the columns' energy that ``base`` cannot produce (1: orthogonal to it, 0: absorbed)."""
        gram, _ = self.marginal(np.asarray([*base, *index], dtype=np.int64), self.noise.offset_variances[-1])
        total = gram.sum(axis=0)[:-1, :-1]
        b = len(base)
        inner = total[:b, :b] + np.diag(np.diag(total)[:b] * 1e-9 + 1e-300)
        left = total[b:, b:] - total[b:, :b] @ np.linalg.solve(inner, total[:b, b:])
        return float(np.trace(left) / max(np.trace(total[b:, b:]), 1e-300))
