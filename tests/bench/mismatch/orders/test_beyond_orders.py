"""What of an effect in the offset the simulation's orders can say as well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.orders.beyond_orders import beyond_orders
from bench.mismatch.regression.problem import nominal_base
from bench.simulation.frame import FloatArray
from bench.simulation.terms import TRANSMISSION_ERROR
from tests.bench.simulation.terms.frames import frame

ORDERS = (3.0, 12.0)
TURNS = 1.3


def driven(ramp: bool) -> tuple:  # type: ignore[type-arg]
    """Three recordings of a little over a revolution, at one speed or up to it; samples of each row."""
    made = frame()
    share = made.elapsed / made.elapsed.max()
    speed = np.abs(made.velocity).max() * (share if ramp else 1.0)
    theta = 2.0 * np.pi * TURNS * (share**2 if ramp else share)
    made = replace(
        made,
        theta=theta,
        q=theta,
        velocity=made.direction * speed,
        last_direction=made.direction,
        torque=np.full(made.size, 100.0) * (made.recording + 1.0),
    )
    return made, np.full(made.size, 25.0), [t.regressor for t in nominal_base(TRANSMISSION_ERROR, ())]


@pytest.mark.parametrize("order", ORDERS)
def test_a_wave_of_an_order_is_the_orders_own(order: float) -> None:
    made, number, base = driven(False)
    wave: FloatArray = (1.0 + 0.3 * made.torque / 100.0) * np.cos(order * made.theta + 0.4)
    assert np.abs(beyond_orders(wave, base, made, number, ORDERS)).max() < 1e-4
    assert np.abs(beyond_orders(wave, base, made, number, ())).max() > 0.1


def test_orders_take_a_part_of_what_happens_in_a_ramp_and_leave_waves_elsewhere() -> None:
    made, number, base = driven(True)
    early = np.exp(-np.abs(made.velocity) / 0.01)
    alone, beside = (beyond_orders(early, base, made, number, orders) for orders in ((), ORDERS))
    assert np.sum(beside**2) < 0.8 * np.sum(alone**2)
    late = made.elapsed > 0.5 * made.elapsed.max()
    assert np.mean(beside[late] ** 2) / np.mean(beside**2) > np.mean(alone[late] ** 2) / np.mean(alone**2)
    # rows of no samples are none by which anything is calibrated
    assert np.array_equal(beyond_orders(early, base, made, np.zeros(made.size), ORDERS), early)
