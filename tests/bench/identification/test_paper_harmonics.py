from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.identification.samples.paper_harmonics import (
    equidistant,
    fourier_sums,
    notch,
    padded_amplitudes,
    padded_length,
    padded_spectrum,
    paper_harmonics,
)


def _error(theta: np.ndarray, waves: dict[float, tuple[float, float]]) -> np.ndarray:
    return sum((a * np.sin(f * theta + p) for f, (a, p) in waves.items()), np.zeros_like(theta))


def test_padding_goes_to_the_next_power_of_two_above_ten_times_the_length() -> None:
    assert padded_length(1000) == 16384
    assert padded_length(1024) == 16384


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 700), st.floats(0.0, 6.3))
def test_block_sums_are_the_plain_sum(size: int, rate: float) -> None:
    x = np.random.default_rng(size).normal(size=size)
    direct = (x * np.exp(-1j * rate * np.arange(size))).sum()
    assert abs(fourier_sums(x, np.array([rate]))[0] - direct) < 1e-9 * size


def test_single_bins_are_those_of_the_whole_padded_spectrum() -> None:
    theta = np.linspace(0.2, 0.2 + 2.02 * np.pi, 6000)
    error = _error(theta, {3: (1e-5, 0.4), 46: (2e-5, -1.0)})
    step = theta[1] - theta[0]
    orders, amplitude = padded_spectrum(error, step)
    for f in (3, 13, 46):
        nearest = amplitude[np.argmin(np.abs(orders - f))]
        assert padded_amplitudes(error, step, [f])[0] == pytest.approx(nearest, rel=1e-9)


@pytest.mark.parametrize("backwards", [False, True])
def test_lone_orders_come_out_right_in_both_directions(backwards: bool) -> None:
    theta = np.linspace(0.3, 0.3 + 2.02 * np.pi, 20_000)
    error = _error(theta, {9: (1e-5, 0.7), 46: (2e-5, -2.0)}) + 3e-4
    if backwards:
        theta, error = theta[::-1], error[::-1]
    got = paper_harmonics(theta, error, [9, 46], [150, 300])
    assert got.amplitude == pytest.approx([1e-5, 2e-5], rel=0.02)
    assert got.phase == pytest.approx([0.7, -2.0], abs=0.01)
    assert got.offset == pytest.approx(3e-4, rel=1e-2)


def test_close_orders_leak_into_each_other() -> None:
    # A Hamming window over one revolution has a main lobe four orders wide: 13 holds part of 14.
    theta = np.linspace(0.0, 2.0 * np.pi, 20_000, endpoint=False)
    error = _error(theta, {13: (1e-5, 0.0), 14: (1e-5, 0.3)})
    got = paper_harmonics(theta, error, [13, 14], [])
    assert np.abs(got.amplitude / 1e-5 - 1.0).max() > 0.2


def test_notch_takes_the_ripple_and_leaves_its_neighbours() -> None:
    theta = np.linspace(0.0, 4.0 * np.pi, 40_000, endpoint=False)
    step = theta[1] - theta[0]
    left = notch(_error(theta, {150: (1e-5, 0.0)}), step, [150])
    kept = notch(_error(theta, {138: (1e-5, 0.0)}), step, [150])
    middle = slice(10_000, 30_000)
    assert np.abs(left[middle]).max() < 5e-7
    assert np.abs(kept[middle]).max() == pytest.approx(1e-5, rel=0.05)


def test_interpolation_survives_an_encoder_that_steps_back() -> None:
    theta = np.linspace(0.0, 1.0, 1000) + 2e-3 * np.random.default_rng(0).normal(size=1000)
    grid, even = equidistant(theta, theta)
    assert np.all(np.diff(grid) > 0)
    assert np.isfinite(even).all()
