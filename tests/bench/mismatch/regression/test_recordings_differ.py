"""Numbers that recordings do not agree on are less sure than their rows say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.bank import Normal, solve
from bench.mismatch.regression.beside import differs_from_zero
from bench.mismatch.regression.model import Chosen, add_block
from bench.mismatch.regression.recordings_differ import Differences, apart, wider
from bench.mismatch.regression.regressors import named
from bench.mismatch.regression.search import begun
from bench.mismatch.regression.succession import _least_sure
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import campaign, problem

SIGMA = 0.01


@pytest.mark.parametrize(("alike", "doubtful"), [(True, False), (False, True)])
def test_an_effect_that_recordings_have_with_any_sign_is_doubtful(alike: bool, doubtful: bool) -> None:
    frame, rng = campaign(), np.random.default_rng(4)
    wave = named("load.unbalance", MOTOR_TORQUE, LIBRARY["load.unbalance"].forms[MOTOR_TORQUE][0].name, ())
    # two of a pair turn to either side at about the same speed
    signs = np.where(np.arange(int(frame.recording.max()) + 1) % 4 < 2, 1.0, -1.0)
    size = 0.05 * (np.ones_like(signs) if alike else signs)[frame.recording]
    course = wave.columns(frame)[:, 0] / np.abs(wave.columns(frame)[:, 0]).max()
    y = 0.6 * frame.direction + size * course + rng.normal(scale=SIGMA, size=frame.size)
    search = begun(problem(frame, y))
    block = add_block(search.model.problem, search.bank, wave)
    effect = Chosen(block)
    model = replace(search.model, chosen=[effect], fit=search.model.refitted([effect]))
    assert (_least_sure(model) is effect) is doubtful
    noise = np.sqrt(np.diag(model.fit.of(block.indices)[1]))
    assert bool(np.all(model.std(block.indices) > 2.0 * noise)) is doubtful


def test_two_recordings_widen_nothing() -> None:
    """One always agrees with itself, and two may by chance."""
    rng = np.random.default_rng(1)
    influence, left = rng.normal(size=(100, 1)), rng.normal(size=100)
    assert np.all(apart(influence, left + 5.0 * influence[:, 0], np.array([0, 50, 100])) == 0.0)


def test_independent_rows_widen_little() -> None:
    rng = np.random.default_rng(2)
    factors = []
    for _ in range(50):
        columns = rng.normal(size=(2000, 2))
        covariance = np.linalg.inv(columns.T @ columns)
        seen = apart(columns @ covariance, rng.normal(size=2000), np.arange(0, 2001, 50))
        factors.append(np.sqrt(np.diag(wider(covariance, seen)) / np.diag(covariance)))
    assert 1.0 <= np.median(factors) < 1.15
    assert np.max(factors) < 1.7


@pytest.mark.parametrize("direction", [(1.0, 1.0), (1.0, -1.0)])
def test_only_the_direction_in_which_recordings_differ_is_less_sure(direction: tuple[float, float]) -> None:
    """Of two columns that are nearly alike the sum is sure though neither is: and the other way round."""
    covariance = np.array([[1.0, -0.99], [-0.99, 1.0]])
    way = np.asarray(direction) / np.sqrt(2.0)
    other = way * (1.0, -1.0)
    told = wider(covariance, 9.0 * np.outer(way, way))
    assert way @ told @ way == pytest.approx(9.0, rel=1e-6)
    assert other @ told @ other == pytest.approx(other @ covariance @ other, rel=1e-6)


def test_of_columns_that_were_not_asked_nothing_is_known() -> None:
    assert Differences((3,), np.eye(1)).widened([4], np.eye(1) * 0.01) == pytest.approx(0.01)
    assert Differences((3,), np.eye(1)).widened([3], np.eye(1) * 0.01) == pytest.approx(1.0)


def test_a_direction_that_is_fixed_makes_nothing_sure() -> None:
    """The values of a table have a mean of zero: that they have it exactly says nothing of the table."""
    fixed = np.array([[1.0, -1.0], [-1.0, 1.0]]) + 1e-12
    assert not differs_from_zero(np.array([-1.3, 1.3 + 1e-4]), fixed)
    assert differs_from_zero(np.array([-2.5, 2.5]), fixed)
    # two that are nearly alike are sure together
    assert differs_from_zero(np.array([1.0, 1.0]), np.array([[1.0, -0.99], [-0.99, 1.0]]))


@pytest.mark.parametrize("columns", [2, 6, 12])
def test_columns_that_are_the_same_are_sure_together(columns: int) -> None:
    rng = np.random.default_rng(5)
    one = rng.normal(size=400)
    x = np.repeat(one[:, None], columns, axis=1)
    y = 2.0 * one + rng.normal(size=400)
    coefficients, covariance, _ = solve(Normal(x.T @ x, x.T @ y, float(y @ y), 0.0))
    assert coefficients.sum() == pytest.approx(2.0, abs=0.2)
    assert differs_from_zero(coefficients, covariance)


def test_differences_of_a_model_widen_another_fit_in_proportion() -> None:
    """Beside an effect that is nearly alike a base's number is unsure; without it it is not, if recordings agree."""
    frame, rng = campaign(), np.random.default_rng(6)
    drag = named("friction.stribeck", MOTOR_TORQUE, "gaussian", (200.0,))
    y = 0.6 * frame.direction + rng.normal(scale=SIGMA, size=frame.size)
    search = begun(problem(frame, y))
    effect = Chosen(add_block(search.model.problem, search.bank, drag))
    model = replace(search.model, chosen=[effect], fit=search.model.refitted([effect]))
    model.compare_recordings()
    coulomb = next(b for b in model.base if b.regressor.effect == "friction.coulomb").indices
    alone = model.refitted([])
    plain = np.sqrt(np.diag(alone.of(coulomb)[1]))
    assert model.std(coulomb)[0] > 3.0 * plain[0]
    assert model.std(coulomb, alone)[0] < 2.0 * plain[0]
