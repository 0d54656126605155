"""Noise from spectra: the size that was put in, whatever lines stand in it."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.regression.noise import MEMORIES_S, Mixture, mixture
from tests.bench.mismatch.spectra import densities


def found(**what: object) -> Mixture:
    own = mixture(densities(3, **what))  # type: ignore[arg-type]
    assert own is not None
    return own


def test_white_noise_is_white() -> None:
    own = found(white=4.0)
    assert own.variance == pytest.approx(4.0, rel=0.05)
    assert own.white == pytest.approx(4.0, rel=0.08)


def test_a_mixture_is_recovered() -> None:
    own = found(white=1.0, slow=2.0, memory=0.3)
    assert own.white == pytest.approx(1.0, rel=0.08)
    assert sum(own.parts) == pytest.approx(2.0, rel=0.15)
    time = float(np.dot(own.parts, MEMORIES_S) / sum(own.parts))
    assert 0.15 < time < 0.6


def test_physics_in_a_few_bins_is_no_noise() -> None:
    own = found(white=1.0, order=(900.0, 3.0))
    assert own.variance == pytest.approx(1.0, rel=0.06)


def test_means_scatter_as_the_mixture_says() -> None:
    own = Mixture(1.0, (0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0), 100.0)
    rng = np.random.default_rng(5)
    keep = np.exp(-1.0 / (100.0 * 0.1))
    values = np.zeros((4000, 50))
    state = rng.normal(size=4000) * np.sqrt(2.0)
    for k in range(50):
        values[:, k] = state + rng.normal(size=4000)
        state = keep * state + np.sqrt(2.0 * (1.0 - keep**2)) * rng.normal(size=4000)
    told = own.of_means(np.array([50.0]), np.array([0.5]))[0]
    assert np.var(values.mean(axis=1)) == pytest.approx(told, rel=0.08)


def test_too_few_spectra_tell_nothing() -> None:
    assert mixture(densities(1, recordings=2)) is None
