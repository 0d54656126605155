from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bench.simulation import Standardisation, basis
from bench.simulation.polynomial import EXPONENTS

numbers = st.floats(-2000.0, 2000.0)


def test_terms_stand_in_the_papers_order() -> None:
    row = basis(2.0, 3.0, 5.0)
    assert row.tolist() == [4.0, 9.0, 25.0, 2.0, 3.0, 5.0, 6.0, 10.0, 15.0, 1.0]
    assert [2.0**a * 3.0**b * 5.0**c for a, b, c in EXPONENTS] == row.tolist()


@given(st.lists(st.tuples(numbers, st.floats(-0.2, 0.2), st.floats(10.0, 60.0)), min_size=3, max_size=20))
def test_scaling_back_to_raw_inputs_changes_no_value(points: list[tuple[float, float, float]]) -> None:
    inputs = np.array(points).T
    standard = Standardisation.of(*inputs)
    coefficients = np.linspace(-1.0, 1.0, 10)
    scaled = standard.basis(*inputs) @ coefficients
    raw = basis(*inputs) @ standard.to_raw(coefficients)
    size = np.abs(basis(*inputs)) @ np.abs(standard.to_raw(coefficients)) + 1.0
    assert np.all(np.abs(raw - scaled) < 1e-9 * size)


def test_an_input_that_does_not_vary_keeps_its_scale() -> None:
    standard = Standardisation.of([1.0, 2.0], [0.1, 0.1], [30.0, 30.0])
    assert standard.std[1:].tolist() == [1.0, 1.0]


def test_covariance_is_scaled_like_the_coefficients() -> None:
    rng = np.random.default_rng(0)
    standard = Standardisation(np.array([10.0, 0.1, 30.0]), np.array([500.0, 0.05, 9.0]))
    draws = rng.normal(size=(4000, 10))
    expected = np.cov(standard.to_raw(draws).T)
    got = standard.covariance_to_raw(np.eye(10))
    scale = np.sqrt(np.outer(np.diag(got), np.diag(got)))
    assert np.abs((got - expected) / scale).max() < 0.1
