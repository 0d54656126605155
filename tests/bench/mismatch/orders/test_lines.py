"""Orders of a torque: what is the same both ways, what changes with the direction, and noise."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.orders.lines import Revolutions, significant_lines
from bench.mismatch.orders.torques import OUTPUT_MODELS, name_of
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE

NOISE = 0.002


def revolutions(constant: complex, by_direction: complex, seed: int = 0) -> Revolutions:
    """Thirty revolutions both ways, with an order 1 of two parts."""
    rng = np.random.default_rng(seed)
    number, orders = 30, 61
    vectors = NOISE * (rng.normal(size=(number, orders)) + 1j * rng.normal(size=(number, orders)))
    direction = np.where(np.arange(number) % 2 == 0, 1.0, -1.0)
    load = rng.uniform(-1.0, 1.0, number)
    vectors[:, 1] += constant + by_direction * direction
    factors = {"1": np.ones(number), "d": direction, "tau": load, "d*abs_tau": direction * np.abs(load)}
    return Revolutions(vectors, np.full(number, NOISE), factors, np.arange(number, dtype=np.int64))


def test_noise_has_no_orders() -> None:
    """Nothing stands in noise."""
    assert significant_lines(revolutions(0.0, 0.0), OUTPUT_MODELS, 0) == []


@pytest.mark.parametrize(
    ("constant", "by_direction", "model", "effect"),
    [(0.02 + 0.01j, 0.0, ("1",), "load.unbalance"), (0.0, 0.03j, ("d",), "friction.position_dependent")],
)
def test_what_an_order_is_in_proportion_to(
    constant: complex, by_direction: complex, model: tuple[str, ...], effect: str
) -> None:
    """Gravity is the same both ways, friction is not."""
    found = significant_lines(revolutions(constant, by_direction), OUTPUT_MODELS, 0)
    assert [line.order for line in found] == [1]
    assert found[0].model == model
    assert name_of(MOTOR_TORQUE, 1, model[0]) == effect
    true = constant + by_direction
    assert abs(found[0].amplitude[0] - true) < 4.0 * np.sqrt(2.0 * found[0].variance[0])
    # richer models with the same factor predict as well: they say the same of the effect
    assert sum(share for tried, share in found[0].shares.items() if model[0] in tried) > 0.9


def test_friction_is_none_of_the_torque_sensor() -> None:
    """What changes its sign with the direction behind the sensor has no name there."""
    assert name_of(LOAD_TORQUE, 1, "d") == "unknown"
    assert name_of(LOAD_TORQUE, 2, "tau") == "unknown"


@pytest.mark.parametrize("order", [1, 2, 30, 60])
def test_a_strong_order_is_no_noise_at_either_end_of_those_that_are_looked_at(order: int) -> None:
    given = revolutions(0.0, 0.0)
    vectors = given.vectors.copy()
    vectors[:, order] += 8.0 * NOISE
    few = np.arange(8)
    shown = Revolutions(vectors[few], given.sigma[few], {k: v[few] for k, v in given.factors.items()}, few)
    found = significant_lines(shown, OUTPUT_MODELS, 0)
    assert [line.order for line in found] == [order]
