from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.identification.samples.sums import TOLERANCE, Shifts, angle_sums, gram, projections


def _matrix(theta: np.ndarray, orders: np.ndarray) -> np.ndarray:
    waves = np.outer(theta, orders)
    return np.hstack([np.sin(waves), np.cos(waves), np.ones((theta.size, 1))])


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**31), st.integers(30, 400), st.floats(-50.0, 50.0), st.floats(0.1, 20.0))
def test_sums_are_those_of_the_matrix_that_is_not_built(seed: int, n: int, start: float, span: float) -> None:
    rng = np.random.default_rng(seed)
    theta, y = start + span * rng.random(n), rng.normal(size=n)
    orders = np.array([1, 13, 14, 46])
    unit, both = angle_sums(theta, np.ones(n), y, 2 * 46)
    x = _matrix(theta, orders)
    bound = 100.0 * TOLERANCE * np.abs(y).sum() + 100.0 * TOLERANCE * n
    assert np.abs(gram(unit, orders) - x.T @ x).max() < bound
    assert np.abs(projections(both, orders) - x.T @ y).max() < bound


def test_sums_of_a_series_follow_from_the_unit_sums() -> None:
    rng = np.random.default_rng(3)
    theta, orders = rng.uniform(0, 6, 200), np.array([2, 5, 9])
    unit, _ = angle_sums(theta, np.ones(200), np.zeros(200), 30)
    coefficients = rng.normal(size=7)
    series = _matrix(theta, orders) @ coefficients
    direct = np.exp(1j * np.outer(np.arange(16), theta)) @ series
    shifts = Shifts.of(np.arange(16.0), orders, unit.shape[-1])
    assert np.abs(shifts.series(unit[None, :], coefficients[None, :]) - direct).max() < 1e-6


def test_high_orders_cost_no_matrix() -> None:
    rng = np.random.default_rng(4)
    theta = np.sort(rng.uniform(0, 2 * np.pi, 20_000))
    y = 1e-5 * np.sin(4440 * theta + 0.3)
    sums, _ = angle_sums(theta, y, np.zeros_like(y), 5000)
    amplitude = 2.0 * np.abs(sums) / theta.size
    assert int(np.argmax(amplitude)) == 4440
    assert np.isclose(amplitude[4440], 1e-5, rtol=0.05)
