"""Orders that are no whole number: their sums, and a model with one, found again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.cli.identify import parse_ratios
from bench.errors import BenchError
from bench.identification import Options, identify_folder
from bench.identification.samples.fractions import columns, extra_frequencies, fractions, sums_at
from bench.identification.samples.sums import Shifts, angle_sums, gram, projections
from bench.identification.validation import BOUND
from bench.simulation import basis
from tests.bench.identification.synthetic import Bench, true_model

ORDERS = (1, 3, 7.297, 14, 46)


def _matrix(theta: np.ndarray, orders: np.ndarray) -> np.ndarray:
    waves = np.outer(theta, orders)
    return np.hstack([np.sin(waves), np.cos(waves), np.ones((theta.size, 1))])


def test_sums_with_fractions_are_those_of_the_matrix_that_is_not_built() -> None:
    rng = np.random.default_rng(2)
    theta, y, highest_order = rng.uniform(-9.0, 9.0, 300), rng.normal(size=300), 20
    orders = np.array([1.0, 2.5, 7.297, 13.0])
    broken = fractions(list(orders))
    extra = extra_frequencies(broken, highest_order)
    unit, both = angle_sums(theta, np.ones(300), y, 2 * highest_order)
    unit = np.concatenate([unit, sums_at(theta, np.ones(300), extra)])
    right = np.concatenate([both[: highest_order + 1], sums_at(theta, y, broken)])
    x = _matrix(theta, orders)
    assert np.abs(gram(unit, orders, extra) - x.T @ x).max() < 1e-5
    assert np.abs(projections(right, orders, broken) - x.T @ y).max() < 1e-5
    coefficients = rng.normal(size=9)
    direct = np.exp(1j * np.outer(np.arange(highest_order + 1), theta)) @ (x @ coefficients)
    shifts = Shifts.of(np.arange(highest_order + 1.0), orders, unit.shape[-1] - extra.size, extra)
    assert np.abs(shifts.series(unit[None, :], coefficients[None, :]) - direct).max() < 1e-5


def test_a_sum_that_is_not_there_is_told() -> None:
    with pytest.raises(IndexError, match="not looked at"):
        columns(np.array([7.3]), 20, np.array([7.297]))
    with pytest.raises(IndexError, match="highest"):
        columns(np.array([20.0]), 20, np.array([7.297]))


def test_a_ratio_that_is_no_whole_number_is_identified(tmp_path: Path) -> None:
    model = true_model(ORDERS)
    bench = Bench(tmp_path, model)
    for torque in (-800.0, 0.0, 800.0):
        for velocity in (0.1, 0.15, 0.2):
            bench.write(torque, velocity, 30.0, revolutions=3.02)
    bench.write(400.0, 0.12, 30.0, kind="validation", revolutions=3.02)
    found = identify_folder(tmp_path, Options(orders=ORDERS))
    assert found.orders == ORDERS
    k = ORDERS.index(7.297)
    x = basis(0.0, 0.15, 30.0)
    one, true = found.refined["positive"].fourier, model.positive
    assert true is not None
    z = (one.amplitude[k] @ x) * np.exp(1j * (one.phase[k] @ x))
    z_true = (true.amplitude[k] @ x) * np.exp(1j * (true.phase[k] @ x))
    assert abs(z - z_true) < 0.02 * abs(z_true)
    score = next(s for s in found.scores if s.kind == "validation")
    assert score.rmse["refined"] < 1.1 * score.rmse[BOUND]
    without = identify_folder(tmp_path, Options(orders=tuple(f for f in ORDERS if f != 7.297)))
    worse = next(s for s in without.scores if s.kind == "validation")
    assert worse.rmse[BOUND] > 2.0 * score.rmse[BOUND]


def test_orders_are_numbers_from_one() -> None:
    assert parse_ratios("7.297,1,3", "--orders") == (1, 3, 7.297)
    for text in ("x", "0.5", "nan", "1e9", ""):
        with pytest.raises(BenchError, match="--orders is"):
            parse_ratios(text, "--orders")
