"""Products made when asked for are those of the whole Gram matrix, whatever was asked before."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.mismatch.bank import RIDGE, Bank, Noise, whiten
from bench.mismatch.products import Products

N, RECORDINGS, P = 400, 8, 12
STARTS = np.linspace(0, N, RECORDINGS + 1).astype(np.int64)
FOLDS = np.array([0, 1, 1, 2, 0, 3, 2, 3])


def _marginal(full: np.ndarray, one: np.ndarray, variance: float) -> np.ndarray:
    """Every product a fold, the offsets of a variance marginalised."""
    out = np.zeros((int(FOLDS.max()) + 1, full.shape[1], full.shape[1]))
    for fold, (a, b) in zip(FOLDS, itertools.pairwise(STARTS), strict=True):
        part, ones = full[a:b], one[a:b]
        energy = ones @ ones
        factor = 1.0 / energy if np.isinf(variance) else variance / (1.0 + variance * energy)
        vector = ones @ part
        out[fold] += part.T @ part - factor * np.outer(vector, vector)
    return out


sets = st.lists(st.lists(st.integers(0, P - 1), min_size=1, max_size=5, unique=True), min_size=1, max_size=12)


@settings(deadline=None, max_examples=40)
@given(sets, st.sampled_from([0.0, 0.3, np.inf]), st.integers(0, 10))
def test_any_order_of_asking_gives_the_same_products(asked: list[list[int]], variance: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    columns, y, one = rng.normal(size=(N, P)), rng.normal(size=N), rng.uniform(0.5, 1.0, N)
    products = Products(np.asfortranarray(columns), y, one, STARTS, FOLDS)
    whole = _marginal(np.column_stack([columns, y]), one, variance)
    for chosen in asked:
        shared, own = products.parted(chosen)
        assert sorted([*shared, *own]) == sorted(chosen)
        for left, right in ((shared, own), (own, own), ([P], chosen), (chosen, [*own, P])):
            expected = whole[:, np.array(left, dtype=int)[:, None], np.array(right, dtype=int)[None, :]]
            assert products.marginal(left, right, variance) == pytest.approx(expected, abs=1e-9)


def _by_the_book(bank: tuple[np.ndarray, ...], index: list[int], variance: float) -> np.ndarray:
    """Predictive log-likelihood a fold, each fitted on the others alone: dense, slow, plain."""
    full, one, prior, precision = bank
    keep = [*index, full.shape[1] - 1]
    gram = _marginal(full[:, keep], one, variance)
    energy = [np.sum(one[a:b] ** 2) for a, b in itertools.pairwise(STARTS)]
    total, p = gram.sum(axis=0), len(index)
    present = np.where(np.diag(total)[:p] > 0.0, np.diag(total)[:p], 1.0)
    penalty = np.diag((prior[index] + RIDGE) * present + precision[index])
    out = np.zeros(len(gram))
    for f, own in enumerate(gram):
        others, all_of = total[:p, :p] - own[:p, :p] + penalty, total[:p, :p] + penalty
        beta = np.linalg.solve(others, total[:p, p] - own[:p, p])
        left = own[:p, p] - own[:p, :p] @ beta
        squares = own[p, p] - 2.0 * beta @ own[:p, p] + beta @ own[:p, :p] @ beta - left @ np.linalg.solve(all_of, left)
        cost = np.linalg.slogdet(all_of)[1] - np.linalg.slogdet(others)[1]
        if np.isfinite(variance):
            cost += sum(np.log1p(variance * e) for fold, e in zip(FOLDS, energy, strict=True) if fold == f)
        out[f] = -0.5 * (squares + cost)
    return out


@pytest.mark.parametrize("variance", [0.0, 0.3, np.inf])
def test_the_score_of_a_candidate_is_that_of_a_plain_fit(variance: float) -> None:
    rng = np.random.default_rng(5)
    columns = rng.normal(size=(N, P)) * np.geomspace(1.0, 1e4, P)
    columns[:, 7] = 0.0
    y = columns[:, 1] + rng.normal(size=N)
    noise = Noise(rng.uniform(0.5, 1.5, N), np.full(N, 0.3), (variance,))
    prior, precision = np.full(P, 1e-4), np.where(np.arange(P) == 2, 3.0, 0.0)
    white = whiten(np.column_stack([columns, y, np.ones(N)]), noise, STARTS)
    plain = (white[:, :-1], white[:, -1], prior, precision)
    bank = Bank(y, STARTS, FOLDS, columns, prior, noise, precision)
    for own in ([], [4], [5, 6], [9], [10], [7], [8, 11]):
        chosen = [0, 1, 2, 3, *own]
        fit = bank.fit(chosen)
        assert fit.likelihood == pytest.approx(_by_the_book(plain, chosen, variance), rel=1e-7, abs=1e-7)
        assert fit.coefficients == pytest.approx(bank.fit(chosen, leave_out=False).coefficients, rel=1e-6, abs=1e-9)
    assert bank.fit([3, 0, 2]).coefficients == pytest.approx(bank.fit([0, 2, 3]).coefficients[[2, 0, 1]], rel=1e-7)


def test_a_bank_that_let_go_of_its_candidates_fits_the_rest_the_same() -> None:
    rng = np.random.default_rng(6)
    columns, y = rng.normal(size=(N, P)), rng.normal(size=N)
    noise = Noise(np.ones(N), np.zeros(N), (0.0, 0.1))
    bank = Bank(y, STARTS, FOLDS, columns, np.zeros(P), noise)
    before = [bank.fit([0, 3, 9], leave_out) for leave_out in (True, False)]
    few = bank.only({9, 0, 3, 5})
    after = [few.fit([0, 3, 9], leave_out) for leave_out in (True, False)]
    for a, b in zip(before, after, strict=True):
        assert a.total == pytest.approx(b.total)
        assert a.coefficients == pytest.approx(b.coefficients)
    assert few.explained([5], [0, 3]) == pytest.approx(bank.explained([5], [0, 3]))
