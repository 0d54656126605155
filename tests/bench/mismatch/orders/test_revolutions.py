"""Noise of orders is what differs between revolutions, not what stands in all of them."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.orders.revolutions import Revolution, _levels, scattered

ORDERS = 400
NOISE = 1e-8


def revolutions(number: int) -> list[Revolution]:
    """Steady revolutions, every other one backwards."""
    return [Revolution(k, slice(0, 1), 0.0, 0.1, 30.0, 0.0, 1.0 if k % 2 else -1.0, 1.0, 60.0) for k in range(number)]


def test_what_stands_in_every_revolution_is_no_noise() -> None:
    """A comb a hundred times the noise, as a pulse makes it."""
    rng = np.random.default_rng(1)
    noise = NOISE * (rng.normal(size=(20, ORDERS)) + 1j * rng.normal(size=(20, ORDERS)))
    left = noise + 100.0 * NOISE * np.exp(1j * np.arange(ORDERS))
    assert np.std(scattered(left, revolutions(20))) == pytest.approx(np.std(noise), rel=0.03)
    assert np.std(left) > 50.0 * np.std(noise)


def test_the_noise_among_many_fitted_orders_is_that_of_the_free_ones() -> None:
    """Noise that falls with the order: the fitted ones among the low orders do not pull its level down."""
    rng = np.random.default_rng(2)
    size = NOISE * np.where(np.arange(ORDERS) < 130, 10.0, 1.0)
    left = size * (rng.normal(size=(12, ORDERS)) + 1j * rng.normal(size=(12, ORDERS)))
    fitted = tuple(float(f) for f in range(1, 120) if f % 4)
    found = _levels(left, fitted)
    assert np.median(found[:, 60]) == pytest.approx(10.0 * NOISE, rel=0.3)
    assert np.median(found[:, 300]) == pytest.approx(NOISE, rel=0.3)
