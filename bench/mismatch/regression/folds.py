"""Predictive densities of recordings left out, and what they say of models that compete.

Every operating point is left out in turn, all else fitted, the point's rows predicted: log p(y) - log p(y without the
point), both in closed form. Models are weighted by how often each would be the best if the points were drawn again
(pseudo-BMA with the Bayesian bootstrap: Yao, Vehtari, Simpson and Gelman, Bayesian Anal. 13 (2018) 917).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr
from scipy.stats import wilcoxon

from bench.mismatch import criteria
from bench.mismatch.regression.bank import RIDGE, Bank, Fit
from bench.mismatch.regression.model import Block, ChannelModel, fit_blocks
from bench.mismatch.regression.problem import NUISANCE
from bench.simulation.frame import FloatArray, IntArray

DRAWS = 2000


def predictive(bank: Bank, blocks: Sequence[Block], folds: IntArray, variance: float) -> FloatArray:
    """Log predictive density of each fold (folds,) for a ``variance`` of the offsets.

    ``folds`` (recordings,): fold of each recording of the bank, from 0 without gaps.
    """
    whole, parts, _ = _products(bank, blocks, folds, variance)
    cost = np.zeros(bank.energy.size) if np.isinf(variance) else np.log1p(variance * bank.energy)
    costs = np.bincount(folds, cost, len(parts))
    everything = _evidence(whole) - 0.5 * costs.sum()
    without = np.array([_evidence(_without(whole, fold)) for fold in parts])
    return np.asarray(everything - (without - 0.5 * (costs.sum() - costs)))


def density(model: ChannelModel, blocks: Sequence[Block]) -> FloatArray:
    """Log predictive density of each fold (folds,) with some blocks of a channel, offsets of the likeliest variance."""
    return predictive(model.bank, blocks, model.folds, fit_blocks(model.bank, blocks, model.variances).variance)


def to_be_beaten(model: ChannelModel, blocks: Sequence[Block]) -> FloatArray:
    """Log predictive density of each fold (folds,) with some blocks of a channel, which one with more has to beat.

    With few recordings the offsets that are the likeliest beside the best coefficients are too small, and what is left
    out is predicted too sure of itself: whatever makes up for that would be a gain. So the density is that with the
    offsets that are likely whatever the coefficients are, where this one is higher.
    """
    fitted = fit_blocks(model.bank, blocks, model.variances)
    variances = {fitted.variance, fitted.spread}
    return max((predictive(model.bank, blocks, model.folds, v) for v in variances), key=lambda each: float(each.sum()))


def squares(
    bank: Bank, blocks: Sequence[Block], folds: IntArray, variance: float, fit_zeros: bool = False
) -> FloatArray:
    """Squares of what the model, fitted without it, leaves of each fold (folds,), whitened; see :func:`predictive`.

    A density forgives what the model knows it does not know; squares are what a prediction costs. With ``fit_zeros``
    the zeros of a sensor in the fold itself, which no other fold tells, are fitted to it, at their prior: they are no
    matter of what the model predicts.
    """
    whole, parts, scale = _products(bank, blocks, folds, variance)
    zero = np.array([b.regressor.effect == NUISANCE for b in blocks for _ in b.indices], dtype=bool)
    precision = np.concatenate([b.precision for b in blocks]) / scale**2 if blocks else np.zeros(0)
    out = np.empty(len(parts))
    for f, fold in enumerate(parts):
        without = _without(whole, fold)
        beta = np.linalg.solve(without[:-1, :-1], without[:-1, -1])
        residual = np.append(beta, -1.0)[np.append(fold.indices, whole.shape[0] - 1)]
        slope = fold.gram @ residual
        out[f] = residual @ slope
        zeros_of_fold = np.flatnonzero(zero[fold.indices])
        if fit_zeros and zeros_of_fold.size:
            inner = fold.gram[np.ix_(zeros_of_fold, zeros_of_fold)] + np.diag(precision[fold.indices[zeros_of_fold]])
            out[f] -= slope[zeros_of_fold] @ np.linalg.solve(inner, slope[zeros_of_fold])
    return out


def carried(bank: Bank, blocks: Sequence[Block], block: Block, folds: IntArray, fitted: Fit) -> FloatArray:
    """Share of each fold (folds,) in what is known of one of some fitted blocks, all others free beside it.

    By how much the information on its coefficients, along these themselves, is less without the fold.
    """
    whole, each, scale = _products(bank, blocks, folds, fitted.variance)
    mine = np.isin([i for b in blocks for i in b.indices], block.indices)
    along = fitted.of(block.indices)[0] * scale[mine]

    def information(products: FloatArray) -> float:
        inner, across = products[:-1, :-1], products[:-1, :-1][~mine][:, mine]
        others = np.linalg.solve(inner[~mine][:, ~mine], across)
        return float(along @ (inner[mine][:, mine] - across.T @ others) @ along)

    left = np.array([information(_without(whole, one)) for one in each])
    return np.asarray(1.0 - left / max(information(whole), 1e-300))


@dataclass(frozen=True, slots=True)
class _Fold:
    """Products ``gram`` (s + 1, s + 1) of the columns ``indices`` (s,) that a fold has anything of, and of y, last."""

    indices: IntArray
    gram: FloatArray


def _products(
    bank: Bank, blocks: Sequence[Block], folds: IntArray, variance: float
) -> tuple[FloatArray, list[_Fold], FloatArray]:
    """Products of the blocks' columns and y, offsets marginalised, in columns of unit size: of all folds with the prior
    (k + 1, k + 1), and of each; sizes of the columns (k,).
    """
    index = [i for b in blocks for i in b.indices]
    k = len(index)
    data = np.column_stack([bank.columns.some(index), bank.y])
    starts, weight = bank.whitening.starts, bank.shrunk(variance)
    filled = np.logical_or.reduceat(data[:, :k] != 0.0, starts[:-1], axis=0)
    total = np.zeros((k + 1, k + 1))
    parts = []
    for f in range(int(folds.max()) + 1):
        members = np.flatnonzero(folds == f)
        indices = np.flatnonzero(filled[members].any(axis=0))
        with_y = np.append(indices, k)
        gram = np.zeros((with_y.size, with_y.size))
        for r in members:
            rows = slice(starts[r], starts[r + 1])
            part = data[rows][:, with_y]
            ones = bank.one[rows] @ part
            gram += part.T @ part - weight[r] * np.outer(ones, ones)
        total[np.ix_(with_y, with_y)] += gram
        parts.append(_Fold(indices, gram))
    precision = np.concatenate([b.precision for b in blocks]) if blocks else np.zeros(0)
    scale = np.append(np.sqrt(np.where(np.diag(total)[:k] > 1e-200, np.diag(total)[:k], 1.0)), 1.0)
    prior = np.append(precision / scale[:k] ** 2 + RIDGE, 0.0)
    units = [np.append(scale[one.indices], 1.0) for one in parts]
    scaled = [_Fold(one.indices, one.gram / np.outer(unit, unit)) for one, unit in zip(parts, units, strict=True)]
    return total / np.outer(scale, scale) + np.diag(prior), scaled, scale[:k]


def _without(whole: FloatArray, fold: _Fold) -> FloatArray:
    """Products of all folds but one (k + 1, k + 1).

    Columns are alike and few points part them: only a difference of the products themselves, decomposed once, stays
    positive definite to rounding. An inverse of ``whole`` that is inverted again does not.
    """
    out = whole.copy()
    indices = np.append(fold.indices, whole.shape[0] - 1)
    out[np.ix_(indices, indices)] -= fold.gram
    return out


def _evidence(gram: FloatArray) -> float:
    """Log marginal likelihood, up to what all models share, of scaled products (k + 1, k + 1) with y last."""
    lower = np.linalg.cholesky(gram[:-1, :-1])
    half = np.linalg.solve(lower, gram[:-1, -1])
    return float(-0.5 * (gram[-1, -1] - half @ half) - np.log(np.diag(lower)).sum())


def weights(densities: FloatArray, seed: int, costs: FloatArray | None = None) -> FloatArray:
    """Weight of each model (models,) from the densities (models, folds) of the points left out, less what its
    description ``costs`` (models,).
    """
    models, number = densities.shape
    if models == 1:
        return np.ones(1)
    share = np.random.default_rng(seed).dirichlet(np.ones(number), size=DRAWS)
    drawn = number * share @ densities.T - (np.zeros(models) if costs is None else costs)
    drawn -= drawn.max(axis=1, keepdims=True)
    odds = np.exp(drawn)
    return np.asarray((odds / odds.sum(axis=1, keepdims=True)).mean(axis=0))


def surely_more(first: FloatArray, second: FloatArray) -> bool:
    """Whether ``first`` is more than ``second`` (folds,) in all by more than the points scatter: by the standard errors
    that are asked for, or as surely by rank (Wilcoxon, Biometrics Bull. 1 (1945) 80).

    Where a few points say much and all others say the same, but little, the standard error is as large as what the few
    say.
    """
    more, error = apart(first, second)
    if not more > 0.0:
        return False
    if more >= criteria.BESIDE_UNKNOWN_ERRORS * error:
        return True
    by_chance = float(wilcoxon(first, second, alternative="greater").pvalue)
    return by_chance <= float(ndtr(-criteria.BESIDE_UNKNOWN_ERRORS))


def apart(first: FloatArray, second: FloatArray) -> tuple[float, float]:
    """By how much ``first`` is more than ``second`` (folds,) in all, and the standard error of that."""
    difference = first - second
    error = float(np.std(difference, ddof=1) * np.sqrt(difference.size)) if difference.size > 1 else np.inf
    return float(difference.sum()), error
