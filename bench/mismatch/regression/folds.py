"""Predictive densities of recordings left out, and what they say of models that compete.

Every operating point is left out in turn, all else fitted, the point's rows predicted: log p(y) - log p(y without the
point), both in closed form. Models are weighted by how often each would be the best if the points were drawn again
(pseudo-BMA with the Bayesian bootstrap: Yao, Vehtari, Simpson and Gelman, Bayesian Anal. 13 (2018) 917).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from bench.mismatch.regression.bank import RIDGE, Bank
from bench.mismatch.regression.model import Block
from bench.simulation.frame import FloatArray, IntArray

DRAWS = 2000


def predictive(bank: Bank, blocks: Sequence[Block], folds: IntArray, variance: float) -> FloatArray:
    """Log predictive density of each fold (folds,) for a ``variance`` of the offsets.

    ``folds`` (recordings,): fold of each recording of the bank, from 0 without gaps.
    """
    grams = _grams(bank, blocks, folds, variance)
    cost = np.zeros(bank.energy.size) if np.isinf(variance) else np.log1p(variance * bank.energy)
    costs = np.bincount(folds, cost, grams.shape[0])
    whole, own = _scaled(grams, blocks)
    k = whole.shape[0] - 1
    everything = _evidence(whole[None], k)[0] - 0.5 * costs.sum()
    return np.asarray(everything - (_evidence(whole - own, k) - 0.5 * (costs.sum() - costs)))


def squares(bank: Bank, blocks: Sequence[Block], folds: IntArray, variance: float) -> FloatArray:
    """Squares of what the model, fitted without it, leaves of each fold (folds,), whitened; see :func:`predictive`.

    A density forgives what the model knows it does not know; squares are what a prediction costs.
    """
    whole, own = _scaled(_grams(bank, blocks, folds, variance), blocks)
    k = whole.shape[0] - 1
    if k == 0:
        return np.asarray(own[:, 0, 0])
    without = whole - own
    beta = np.linalg.solve(without[:, :k, :k], without[:, :k, k:])[:, :, 0]
    said = np.concatenate([beta, -np.ones((beta.shape[0], 1))], axis=1)
    return np.asarray(np.einsum("fk,fkl,fl->f", said, own, said))


def _grams(bank: Bank, blocks: Sequence[Block], folds: IntArray, variance: float) -> FloatArray:
    """Products of the blocks' columns and y, offsets marginalised, of each fold (folds, k + 1, k + 1)."""
    index = [i for b in blocks for i in b.place]
    data = np.column_stack([bank.columns.some(index), bank.y])
    starts = bank.whitening.starts
    grams = np.array([data[a:b].T @ data[a:b] for a, b in itertools.pairwise(starts)])
    ones = bank.whitening.by_recording(bank.one[:, None] * data)
    weight = bank.shrunk(variance)
    grams -= weight[:, None, None] * ones[:, :, None] * ones[:, None, :]
    own = np.zeros((int(folds.max()) + 1, *grams.shape[1:]))
    np.add.at(own, folds, grams)
    return own


def _scaled(grams: FloatArray, blocks: Sequence[Block]) -> tuple[FloatArray, FloatArray]:
    """All folds' products with the prior (k + 1, k + 1), and each fold's, in columns of unit size."""
    total = grams.sum(axis=0)
    k = total.shape[0] - 1
    precision = np.concatenate([b.precision for b in blocks]) if blocks else np.zeros(0)
    scale = np.append(np.sqrt(np.where(np.diag(total)[:k] > 1e-200, np.diag(total)[:k], 1.0)), 1.0)
    prior = np.append(precision / scale[:k] ** 2 + RIDGE, 0.0)
    return total / np.outer(scale, scale) + np.diag(prior), grams / np.outer(scale, scale)


def _evidence(grams: FloatArray, k: int) -> FloatArray:
    """Log marginal likelihoods, up to what all models share, of scaled Gram matrices (m, k + 1, k + 1) with y last."""
    squares = grams[:, k, k]
    if k == 0:
        return np.asarray(-0.5 * squares)
    inner, right = grams[:, :k, :k], grams[:, :k, k]
    lower = np.linalg.cholesky(inner)
    half = np.linalg.solve(lower, right[:, :, None])[:, :, 0]
    volume = np.log(np.einsum("mkk->mk", lower)).sum(axis=1)
    return np.asarray(-0.5 * (squares - np.sum(half**2, axis=1)) - volume)


def weights(densities: FloatArray, seed: int) -> FloatArray:
    """Weight of each model (models,) from the densities (models, folds) of the points left out."""
    models, number = densities.shape
    if models == 1:
        return np.ones(1)
    share = np.random.default_rng(seed).dirichlet(np.ones(number), size=DRAWS)
    drawn = number * share @ densities.T
    drawn -= drawn.max(axis=1, keepdims=True)
    odds = np.exp(drawn)
    return np.asarray((odds / odds.sum(axis=1, keepdims=True)).mean(axis=0))


def apart(first: FloatArray, second: FloatArray) -> tuple[float, float]:
    """By how much ``first`` predicts better than ``second`` (folds,), and the standard error of that."""
    difference = first - second
    error = float(np.std(difference, ddof=1) * np.sqrt(difference.size)) if difference.size > 1 else np.inf
    return float(difference.sum()), error
