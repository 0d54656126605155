"""Orders that scatter more than noise are told from those that do not."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.orders.scattering import scattering
from tests.bench.mismatch.unnamed.test_following import FRAME, REVOLUTIONS, model


def test_an_order_that_scatters_is_told_with_its_mean_square() -> None:
    scatter = np.random.default_rng(9).normal(size=len(REVOLUTIONS))[FRAME.recording]
    orders, square = scattering(model(scatter, 4e-7))
    assert orders == (1.0,)
    # a vector of size s that scatters by its size alone; what the polynomials follow of it is none
    assert square == pytest.approx(0.5 * 4e-7**2, rel=0.5)


def test_orders_with_nothing_but_noise_do_not_scatter() -> None:
    assert scattering(model(np.zeros(FRAME.size), 0.0)) == ((), 0.0)
