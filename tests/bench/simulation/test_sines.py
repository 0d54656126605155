"""Sines written out against the C library's."""

from __future__ import annotations

import numpy as np
import pytest

from bench.simulation.sines import phasors, summed, summed_vectors

ANGLE = np.concatenate([np.linspace(-2e4, 2e4, 4001), np.arange(-9, 10) * 0.25 * np.pi, [0.0, 1e6]])


def test_turned_is_the_exponential_to_rounding() -> None:
    table = ANGLE[:4000].reshape(40, 100)
    assert phasors(table).shape == table.shape
    # rounding of the angle itself is as large as the angle times 1e-16
    assert np.abs(phasors(ANGLE) - np.exp(1j * ANGLE)).max() < 3e-16
    assert np.abs(phasors(table) - np.exp(1j * table)).max() < 3e-16


def test_series_are_summed() -> None:
    rng = np.random.default_rng(3)
    angle, orders = rng.uniform(-50.0, 50.0, 300), np.array([1.0, 46.25, 600.0])
    size, phase = rng.normal(size=(3, 300)), rng.uniform(-7.0, 7.0, (3, 300))
    plain = np.sum(size * np.sin(orders[:, None] * angle + phase), axis=0)
    assert summed(angle, orders, size, phase) == pytest.approx(plain, abs=1e-11)
    vectors = size * phasors(phase)
    assert summed_vectors(angle, orders, vectors.real.copy(), vectors.imag.copy()) == pytest.approx(plain, abs=1e-11)
