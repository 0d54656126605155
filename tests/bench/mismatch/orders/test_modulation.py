"""Sidebands: what two orders about a known one have to say more than others."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.orders.modulation import _beyond_usual


def test_a_fall_with_the_order_makes_no_order_unusual() -> None:
    place = np.array([2, 5, 10, 20, 50, 100, 200, 300, 400, 500], dtype=np.int64)
    left = _beyond_usual(place, -11.0 - 0.8 * np.log(place))
    assert np.ptp(left) < 0.3 * 0.8 * np.ptp(np.log(place))
    # one that is larger than its place makes it stays so
    size = -11.0 - 0.8 * np.log(place)
    size[4] += 2.0
    own = _beyond_usual(place, size)
    assert int(np.argmax(own)) == 4
    assert own[4] - np.median(own) == pytest.approx(2.0, abs=0.5)


def test_few_orders_tell_no_fall() -> None:
    place = np.array([18, 20], dtype=np.int64)
    size = np.array([-11.0, -12.0])
    assert _beyond_usual(place, size) == pytest.approx(size, abs=0.05)
