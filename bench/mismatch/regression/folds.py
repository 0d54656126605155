"""Predictive densities of recordings left out, and what they say of models that compete.

Every operating point is left out in turn, all else fitted, the point's rows predicted: log p(y) - log p(y without the
point), both in closed form. Models are weighted by how often each would be the best if the points were drawn again
(pseudo-BMA with the Bayesian bootstrap: Yao, Vehtari, Simpson and Gelman, Bayesian Anal. 13 (2018) 917).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from bench.mismatch.regression.bank import RIDGE, Bank
from bench.mismatch.regression.model import Block
from bench.simulation.frame import FloatArray, IntArray

DRAWS = 2000


def predictive(bank: Bank, blocks: Sequence[Block], folds: IntArray, variance: float) -> FloatArray:
    """Log predictive density of each fold (folds,) for a ``variance`` of the offsets.

    ``folds`` (recordings,): fold of each recording of the bank, from 0 without gaps.
    """
    whole, own = _products(bank, blocks, folds, variance)
    cost = np.zeros(bank.energy.size) if np.isinf(variance) else np.log1p(variance * bank.energy)
    costs = np.bincount(folds, cost, len(own))
    everything = _evidence(whole[None])[0] - 0.5 * costs.sum()
    out = np.empty(len(own))
    for chosen, without, volume in _left_out(whole, own):
        out[chosen] = everything - (_evidence(without) - 0.5 * volume - 0.5 * (costs.sum() - costs[chosen]))
    return out


def squares(bank: Bank, blocks: Sequence[Block], folds: IntArray, variance: float) -> FloatArray:
    """Squares of what the model, fitted without it, leaves of each fold (folds,), whitened; see :func:`predictive`.

    A density forgives what the model knows it does not know; squares are what a prediction costs.
    """
    whole, own = _products(bank, blocks, folds, variance)
    out = np.empty(len(own))
    for chosen, without, _ in _left_out(whole, own):
        grams = np.array([own[int(f)].gram for f in chosen])
        beta = np.linalg.solve(without[:, :-1, :-1], without[:, :-1, -1:])[:, :, 0]
        said = np.concatenate([beta, -np.ones((beta.shape[0], 1))], axis=1)
        out[chosen] = np.einsum("fk,fkl,fl->f", said, grams, said)
    return out


@dataclass(frozen=True, slots=True)
class _Fold:
    """Products ``gram`` (s + 1, s + 1) of the columns ``place`` (s,) that a fold has anything of, and of y, last."""

    place: IntArray
    gram: FloatArray


def _products(bank: Bank, blocks: Sequence[Block], folds: IntArray, variance: float) -> tuple[FloatArray, list[_Fold]]:
    """Products of the blocks' columns and y, offsets marginalised, in columns of unit size: of all folds with the prior
    (k + 1, k + 1), and of each.
    """
    index = [i for b in blocks for i in b.place]
    k = len(index)
    data = np.column_stack([bank.columns.some(index), bank.y])
    starts, weight = bank.whitening.starts, bank.shrunk(variance)
    filled = np.logical_or.reduceat(data[:, :k] != 0.0, starts[:-1], axis=0)
    total = np.zeros((k + 1, k + 1))
    own = []
    for f in range(int(folds.max()) + 1):
        members = np.flatnonzero(folds == f)
        place = np.flatnonzero(filled[members].any(axis=0))
        with_y = np.append(place, k)
        gram = np.zeros((with_y.size, with_y.size))
        for r in members:
            rows = slice(starts[r], starts[r + 1])
            part = data[rows][:, with_y]
            ones = bank.one[rows] @ part
            gram += part.T @ part - weight[r] * np.outer(ones, ones)
        total[np.ix_(with_y, with_y)] += gram
        own.append(_Fold(place, gram))
    precision = np.concatenate([b.precision for b in blocks]) if blocks else np.zeros(0)
    scale = np.append(np.sqrt(np.where(np.diag(total)[:k] > 1e-200, np.diag(total)[:k], 1.0)), 1.0)
    prior = np.append(precision / scale[:k] ** 2 + RIDGE, 0.0)
    units = [np.append(scale[one.place], 1.0) for one in own]
    scaled = [_Fold(one.place, one.gram / np.outer(unit, unit)) for one, unit in zip(own, units, strict=True)]
    return total / np.outer(scale, scale) + np.diag(prior), scaled


def _left_out(whole: FloatArray, own: Sequence[_Fold]) -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
    """Folds of a like number of columns; products without each of them (folds, s + 1, s + 1), all columns that it has
    nothing of eliminated; logarithm of the determinant of these (folds,).

    Of the inverse C of all products the part of some columns is the inverse of what is left when the others are
    eliminated. In the heat balance each recording has columns of its own, of which no other has anything.
    """
    k = whole.shape[0] - 1
    sizes = np.array([one.place.size for one in own])
    inverse = np.linalg.inv(whole[:k, :k]) if np.any(sizes < k) else np.zeros((0, 0))
    volume = np.linalg.slogdet(whole[:k, :k])[1]
    beta = inverse @ whole[:k, k] if inverse.size else np.zeros(0)
    for size in np.unique(sizes):
        chosen = np.flatnonzero(sizes == size)
        grams = np.array([own[int(f)].gram for f in chosen])
        if size == k:
            yield chosen, whole - grams, np.zeros(chosen.size)
            continue
        place = np.array([own[int(f)].place for f in chosen])
        part = inverse[place[:, :, None], place[:, None, :]]
        inner = np.linalg.inv(part)
        right = inner @ beta[place][:, :, None]
        left = np.empty((chosen.size, size + 1, size + 1))
        left[:, :size, :size] = inner
        left[:, :size, size:] = right
        left[:, size:, :size] = np.swapaxes(right, 1, 2)
        left[:, size, size] = whole[k, k] - whole[:k, k] @ beta + np.sum(beta[place] * right[:, :, 0], axis=1)
        yield chosen, left - grams, volume + np.linalg.slogdet(part)[1]


def _evidence(grams: FloatArray) -> FloatArray:
    """Log marginal likelihoods, up to what all models share, of scaled Gram matrices (m, k + 1, k + 1) with y last."""
    k = grams.shape[1] - 1
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
