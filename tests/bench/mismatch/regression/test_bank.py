"""Products of whitened columns against dense generalised least squares, and points left out against refits."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from bench.mismatch.regression.bank import RIDGE, Bank, Normal, _likelihoods, fit, solve
from bench.mismatch.regression.folds import apart, predictive, surely_more, to_be_beaten, weights
from bench.mismatch.regression.model import Block, ChannelModel, fit_blocks
from bench.simulation.frame import FloatArray
from tests.bench.mismatch.regression.synthetic import banked, campaign, problem

SIGMA, RHO, VARIANCE, PRIOR = 0.05, 0.4, 4e-4, 2.0
FRAME = campaign(8)
Y = 0.6 * FRAME.direction + 0.01 * FRAME.omega + np.random.default_rng(4).normal(scale=SIGMA, size=FRAME.size)


def made() -> tuple[Bank, list[Block], FloatArray]:
    """The bank, its blocks with a prior, and its columns (n, k) as they are."""
    own = problem(FRAME, Y)
    bank, base = banked(own, SIGMA, RHO)
    columns = np.hstack([b.regressor.columns(FRAME) for b in base])
    return bank, [replace(b, precision=np.full(len(b.indices), PRIOR)) for b in base], columns


def covariance(variance: float) -> FloatArray:
    """Of all rows (n, n): each correlated with the one before in its recording, which has an offset."""
    same = FRAME.recording[:, None] == FRAME.recording[None, :]
    apart_by = np.abs(np.subtract.outer(np.arange(FRAME.size), np.arange(FRAME.size)))
    return np.where(same, SIGMA**2 * RHO**apart_by + variance, 0.0)


@pytest.mark.parametrize("variance", [0.0, VARIANCE])
def test_a_fit_is_generalised_least_squares(variance: float) -> None:
    bank, blocks, x = made()
    index = [i for b in blocks for i in b.indices]
    found = fit(bank, index, (variance,), np.full(x.shape[1], PRIOR))
    inverse = np.linalg.inv(covariance(variance))
    spread = np.linalg.inv(x.T @ inverse @ x + PRIOR * np.eye(x.shape[1]))
    beta = spread @ (x.T @ inverse @ Y)
    assert found.coefficients == pytest.approx(beta, rel=1e-6)
    assert found.covariance == pytest.approx(spread, rel=1e-5, abs=1e-12)
    squares = float(Y @ inverse @ Y - beta @ (x.T @ inverse @ Y))
    volume = np.linalg.slogdet(covariance(variance))[1] - np.linalg.slogdet(covariance(0.0))[1]
    assert found.likelihood == pytest.approx(-0.5 * (squares + volume), rel=1e-6)


def test_the_likeliest_variance_of_the_offsets_is_chosen() -> None:
    rng = np.random.default_rng(2)
    offset = rng.normal(scale=0.1, size=8)[FRAME.recording]
    own = problem(FRAME, Y + offset)
    bank, base = banked(own, SIGMA, 0.0)
    index = [i for b in base for i in b.indices]
    ladder = bank.variances()
    tried = [fit(bank, index, (v,)).likelihood for v in ladder]
    assert fit(bank, index, ladder).variance == ladder[int(np.argmax(tried))]
    assert fit(bank, index, ladder).variance == pytest.approx(0.01, rel=2.0)


def crowded(seed: int, *more: int) -> tuple[Bank, list[Block]]:
    """Twenty-four recordings with offsets of variance 1, whose sixteen coefficients are of terms that are one value in
    each; and blocks of ``more`` such terms.
    """
    frame = campaign(24)
    rng = np.random.default_rng([seed, 9])
    y = rng.normal(size=24)[frame.recording] + rng.normal(scale=SIGMA, size=frame.size)
    bank, base = banked(problem(frame, y), SIGMA, 0.0)
    terms = [bank.add(rng.normal(size=(24, k))[frame.recording]) for k in (16 - bank.size, *more)]
    return bank, [*base, *(Block(base[0].regressor, t, np.zeros(len(t))) for t in terms)]


def test_terms_that_take_most_of_the_offsets_do_not_make_their_spread_small() -> None:
    """Of twenty-four recordings sixteen are taken by terms that are one value in each: a third of the squares is left,
    and eight offsets tell their variance.
    """
    small, spread = [], []
    for seed in range(8):
        bank, blocks = crowded(seed)
        fitted = fit_blocks(bank, blocks, bank.variances())
        small.append(fitted.variance)
        spread.append(fitted.spread)
    assert np.mean(small) < 0.5
    assert 0.6 < np.mean(spread) < 1.7


@pytest.mark.parametrize("begin", [0, 17, 35])
def test_of_two_hills_of_the_likelihood_the_higher_is_found(begin: int) -> None:
    level = np.linspace(-1.0, 1.0, 8)[FRAME.recording]
    inside = 0.05 * np.sin(FRAME.elapsed)
    # over the recordings the slope is 1, inside them 3: one says the offsets are noise, the other that they are large
    bank, base = banked(problem(FRAME, level + 3.0 * inside + Y), SIGMA, 0.0)
    index = [*(i for b in base for i in b.indices), *bank.add((level + inside)[:, None])]
    ladder = bank.variances()
    tried = [fit(bank, index, (v,)).likelihood for v in ladder]
    hills = [k for k in range(1, len(tried) - 1) if tried[k - 1] < tried[k] >= tried[k + 1]]
    assert len(hills) > 1 or (hills and tried[0] > tried[1])
    bank.likeliest = begin
    assert fit(bank, index, ladder).variance == ladder[int(np.argmax(tried))]


def test_points_left_out_are_predicted_as_by_a_refit() -> None:
    bank, blocks, x = made()
    folds = np.array([0, 1, 2, 3, 0, 1, 2, 3])
    told = predictive(bank, blocks, folds, VARIANCE)
    whole = covariance(VARIANCE)
    for k in range(4):
        out = folds[FRAME.recording] == k
        inverse = np.linalg.inv(whole[np.ix_(~out, ~out)])
        spread = np.linalg.inv(x[~out].T @ inverse @ x[~out] + PRIOR * np.eye(x.shape[1]))
        missed = Y[out] - x[out] @ (spread @ (x[~out].T @ inverse @ Y[~out]))
        total = whole[np.ix_(out, out)] + x[out] @ spread @ x[out].T
        density = -0.5 * (missed @ np.linalg.solve(total, missed) + np.linalg.slogdet(total)[1])
        # rows are whitened: densities are those of values in units of their own noise
        density += 0.5 * np.linalg.slogdet(covariance(0.0)[np.ix_(out, out)])[1]
        assert told[k] == pytest.approx(density, rel=1e-5)


def test_offsets_told_too_small_give_nothing_away() -> None:
    """Two more levels of some recordings, drawn at random, beside sixteen of twenty-four: noise gains by them what the
    offsets beside the best coefficients are told too small.
    """
    told, fair = [], []
    for seed in range(8):
        bank, blocks = crowded(seed, 2)
        own = cast("ChannelModel", SimpleNamespace(bank=bank, folds=np.arange(24), variances=bank.variances()))
        variance = fit_blocks(bank, blocks, bank.variances()).variance
        more = float(predictive(bank, blocks, own.folds, variance).sum())
        less = fit_blocks(bank, blocks[:-1], bank.variances())
        told.append(more - float(predictive(bank, blocks[:-1], own.folds, less.variance).sum()))
        fair.append(more - float(to_be_beaten(own, blocks[:-1]).sum()))
    assert max(told) > 0.0
    assert max(fair) < 0.0


def test_points_left_out_are_predicted_where_columns_are_alike() -> None:
    """Six columns that differ by a ten-millionth, one more that two recordings have."""
    alike = FRAME.omega[:, None] * (1.0 + 1e-7 * np.random.default_rng(6).normal(size=(FRAME.size, 6)))
    x = np.column_stack([alike, FRAME.recording < 2])
    bank, base = banked(problem(FRAME, Y), SIGMA, 0.0)
    block = Block(base[0].regressor, bank.add(x), np.zeros(7))
    folds = np.array([0, 1, 2, 3, 0, 1, 2, 3])
    found = predictive(bank, [block], folds, 0.0)
    # noise beside it: coefficients that nothing determines are held at nothing
    prior = np.diag(RIDGE * np.sum(x**2, axis=0) / SIGMA**2)
    for k in range(4):
        out = folds[FRAME.recording] == k
        spread = np.linalg.inv(x[~out].T @ x[~out] / SIGMA**2 + prior)
        missed = Y[out] - x[out] @ (spread @ (x[~out].T @ Y[~out] / SIGMA**2))
        total = np.eye(int(out.sum())) + x[out] @ spread @ x[out].T / SIGMA**2
        density = -0.5 * (missed @ np.linalg.solve(total, missed) / SIGMA**2 + np.linalg.slogdet(total)[1])
        assert found[k] == pytest.approx(density, rel=1e-4)


def test_a_model_that_predicts_better_everywhere_has_all_the_weight() -> None:
    good = np.zeros(12)
    share = weights(np.array([good, good - 3.0, good - 20.0]), 1)
    assert share.sum() == pytest.approx(1.0)
    assert share[0] > 0.99
    assert weights(np.array([good, good]), 1) == pytest.approx([0.5, 0.5])
    assert apart(good + 2.0, good) == (24.0, 0.0)


@pytest.mark.parametrize(
    ("difference", "surely"),
    [
        # two standard errors
        (np.random.default_rng(3).normal(1.0, 1.0, 40), True),
        (np.random.default_rng(3).normal(0.1, 1.0, 40), False),
        # recordings with reversals say most, and all others say the same
        (np.r_[np.random.default_rng(3).normal(2.0, 1.0, 38), 900.0, 1600.0], True),
        # the others say nothing
        (np.r_[np.random.default_rng(3).normal(0.0, 1.0, 38), 900.0, 1600.0], False),
        # or the contrary
        (np.r_[np.random.default_rng(3).normal(-2.0, 1.0, 38), 900.0, 1600.0], False),
        (np.zeros(12), False),
    ],
)
def test_a_few_points_decide_where_all_others_say_the_same(difference: FloatArray, surely: bool) -> None:
    assert surely_more(difference, np.zeros(difference.size)) is surely


@pytest.mark.parametrize("alike", [False, True])
def test_one_factor_says_how_likely_a_model_is_as_the_whole_solution_does(alike: bool) -> None:
    """``alike``: two columns that only rounding tells apart, for which there may be no factor."""
    rng = np.random.default_rng(3)
    x = rng.normal(size=(300, 6)) * 10.0 ** rng.uniform(-4.0, 4.0, 6)
    if alike:
        x[:, 5] = x[:, 4] * (1.0 + 1e-16)
    y = rng.normal(size=300)
    normal = Normal(x.T @ x, x.T @ y, float(y @ y), 3.0)
    precision = rng.uniform(size=6)
    _, covariance, likelihood = solve(normal, precision)
    found, taken = _likelihoods(normal, precision)
    assert found == pytest.approx(likelihood, rel=1e-9)
    assert taken == pytest.approx(0.5 * np.linalg.slogdet(covariance)[1], abs=1e-4 if alike else 1e-9)


def test_where_there_is_no_factor_the_whole_solution_says_it() -> None:
    """Rounding may leave normal equations that are no sum of squares."""
    gram = np.array([[1.0, 1.5], [1.5, 1.0]])
    normal = Normal(gram, np.array([1.0, 0.5]), 4.0, 0.5)
    _, covariance, likelihood = solve(normal, 0.0)
    assert _likelihoods(normal, 0.0) == pytest.approx((likelihood, 0.5 * np.linalg.slogdet(covariance)[1]))
    assert _likelihoods(Normal(np.zeros((0, 0)), np.zeros(0), 4.0, 0.5), 0.0) == (-2.25, 0.0)
