"""The series' calibration, and what stands in the order spectrum beside it."""

import numpy as np
import pytest

from bench.mismatch.peaks import Spectra, pulse_spectrum, search
from bench.mismatch.series import Scaling, fit_order

TURNS, ORDERS = 40, 400


def _states(rng: np.random.Generator) -> np.ndarray:
    return np.column_stack(
        [
            rng.choice([-1000.0, -500.0, 0.0, 500.0, 1000.0], TURNS),
            rng.uniform(0.04, 0.17, TURNS),
            rng.uniform(20, 50, TURNS),
        ]
    )


def _noise(rng: np.random.Generator, sigma: float = 4e-8) -> np.ndarray:
    return sigma * (rng.normal(size=(TURNS, ORDERS + 1)) + 1j * rng.normal(size=(TURNS, ORDERS + 1)))


def _spectra(vectors: np.ndarray, rng: np.random.Generator, carriers: dict[int, np.ndarray] | None = None) -> Spectra:
    direction = np.where(np.arange(TURNS) % 2 == 0, 1.0, -1.0)
    return Spectra(
        vectors,
        np.full((TURNS, ORDERS + 1), 4e-8),
        _states(rng),
        direction,
        np.ones(TURNS, bool),
        (1, 46, 150, 300),
        carriers or {},
        2e-6,
    )


@pytest.fixture(name="rng")
def _rng() -> np.random.Generator:
    return np.random.default_rng(3)


def test_amplitude_and_phase_polynomials_come_back(rng: np.random.Generator) -> None:
    x = _states(rng)
    scaling = Scaling(x.mean(axis=0), x.std(axis=0))
    basis = scaling.monomials(x)
    amplitude = 1e-5 * np.array([0.05, -0.02, 0.01, 0.2, 0.1, -0.1, 0.03, 0.02, 0.01, 1.0])
    phase = np.array([0.1, 0.02, -0.05, 0.8, 0.2, 0.1, 0.05, 0.02, 0.0, 2.9])
    vector = (basis @ amplitude) * np.exp(1j * (basis @ phase))
    vector = vector + 1e-9 * (rng.normal(size=TURNS) + 1j * rng.normal(size=TURNS))
    a, p, _, _ = fit_order(basis, vector, np.full(TURNS, 1e-9))
    assert np.abs((basis @ a) * np.exp(1j * (basis @ p)) - vector).max() < 2e-7


def test_noise_alone_gives_nothing(rng: np.random.Generator) -> None:
    assert search(_spectra(_noise(rng), rng)) == []


def test_a_new_order_is_found_and_only_that(rng: np.random.Generator) -> None:
    vectors = _noise(rng)
    vectors[:, 37] += 6e-7 * np.exp(0.4j)
    found = search(_spectra(vectors, rng))
    assert [(p.kind, p.orders) for p in found] == [("order", (37,))]
    assert abs(found[0].coefficients[0][0]) == pytest.approx(6e-7, rel=0.05)


def test_sidebands_are_a_pair_about_their_carrier(rng: np.random.Generator) -> None:
    carrier = 2e-5 * np.exp(1j * rng.uniform(0, 6, TURNS))
    vectors = _noise(rng)
    vectors[:, 43] += 0.05 * carrier
    vectors[:, 49] += 0.05 * carrier
    found = search(_spectra(vectors, rng, {46: carrier}))
    assert [(p.kind, p.orders, p.carrier) for p in found] == [("sideband", (43, 49), 46)]


def test_a_pulse_is_one_defect_and_not_many_orders(rng: np.random.Generator) -> None:
    f = np.arange(ORDERS + 1.0)
    vectors = _noise(rng) + 1.5e-5 * pulse_spectrum(0.025, f) * (np.sin(f * 2.0) + 1j * np.cos(f * 2.0))
    found = search(_spectra(vectors, rng))
    assert found[0].kind == "pulse"
    assert found[0].angle == pytest.approx(2.0, abs=0.01)
    assert found[0].height == pytest.approx(1.5e-5, rel=0.15)
    assert all(p.kind == "pulse" for p in found)
