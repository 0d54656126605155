"""A mode after a change of speed: steady response and free oscillation are what its differential equation says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lsim

from bench.simulation.frame import ARRAYS, FloatArray, Frame
from bench.simulation.free_oscillation import _steps, free_oscillation, over_angle
from bench.simulation.laws import Law, factor

NATURAL, DAMPING, SHARE = 12.0, 0.03, 0.6
ORDERS = np.array([46.0, 92.0, 185.0])
VECTORS = np.array([20.0 + 5.0j, 8.0 - 3.0j, 2.0 + 1.0j]) * 1e-6
RATE_HZ = 1000
DIED_AWAY_S = 12.0
"""the equation begins at rest; by then what it begins with has fallen to a hundredth"""
SYSTEMS = {
    "second_order": ([NATURAL**2], [1.0, 2.0 * DAMPING * NATURAL, NATURAL**2], 1.0),
    "second_order_of_base": ([-1.0, 0.0, 0.0], [1.0, 2.0 * DAMPING * NATURAL, NATURAL**2], 0.0),
}
"""numerator and denominator of what answers the orders, and how much of them is taken off it"""


def _run() -> tuple[FloatArray, FloatArray, FloatArray]:
    time = np.arange(0.0, 40.0, 1.0 / RATE_HZ)
    faster = ((time > 18.0) & (time < 18.4)) * 0.3
    slower = ((time > 28.0) & (time < 28.3)) * 0.25
    velocity = 0.1 + np.cumsum(faster - slower) / RATE_HZ
    return time, np.cumsum(velocity) / RATE_HZ, velocity


def _frame(time: FloatArray, theta: FloatArray, velocity: FloatArray) -> Frame:
    values = {name: np.zeros(time.size) for name in ARRAYS}
    values |= {"time": time, "elapsed": time, "theta": theta, "velocity": velocity}
    values |= {"step": np.full(time.size, time[1] - time[0]), "count": np.ones(time.size)}
    return Frame(ratio=185.0, **(values | {"recording": np.zeros(time.size, dtype=np.int64)}))  # type: ignore[arg-type]


@pytest.mark.parametrize("samples", [1, 5, 25])
@pytest.mark.parametrize("form", SYSTEMS)
def test_it_is_what_the_differential_equation_adds(form: str, samples: int) -> None:
    time, theta, velocity = _run()
    driving = np.sum(np.imag(VECTORS * np.exp(1j * theta[:, None] * ORDERS)), axis=1)
    numerator, denominator, less = SYSTEMS[form]
    answer = SHARE * (lsim((numerator, denominator), driving, time)[1] - less * driving)
    means = [x.reshape(-1, samples).mean(axis=1) for x in (time, theta, velocity, answer)]
    frame, true = _frame(*means[:3]), means[3]
    law = Law("te.resonance", form, (NATURAL, DAMPING, SHARE), 0.0, tuple(ORDERS), np.zeros(0, dtype=np.complex128))
    x = np.column_stack([np.zeros(frame.size), frame.velocity, np.zeros(frame.size)])
    by = factor(law, x, frame.time, ORDERS.tolist())
    steady = np.sum(np.imag((by - 1.0) * VECTORS * np.exp(1j * frame.theta[:, None] * ORDERS)), axis=1)
    free = free_oscillation(law, frame, ORDERS, lambda part: np.tile(VECTORS, (part.size, 1)))
    later = frame.time > DIED_AWAY_S
    without, with_it = (float(np.sqrt(np.mean((true - said)[later] ** 2))) for said in (steady, steady + free))
    assert without > 5e-6
    assert with_it < 0.05 * without
    assert np.abs(free[frame.time < 17.9]).max() < 1e-9


def test_a_gap_ends_it() -> None:
    time, theta, velocity = _run()
    late = np.where(time > 19.0, 5.0, 0.0)
    law = Law("te.resonance", "second_order", (NATURAL, DAMPING), 0.0, tuple(ORDERS), np.zeros(0, dtype=np.complex128))
    frame = _frame(time + late, theta, velocity)
    free = free_oscillation(law, frame, ORDERS, lambda part: np.tile(VECTORS, (part.size, 1)))
    inside = (time > 18.5) & (time <= 19.0)
    after = (time > 19.01) & (time < 27.9)
    assert np.abs(free[inside]).max() > 1e-6
    assert np.abs(free[after]).max() < 1e-9


def test_its_change_with_the_angle_is_its_rate_over_the_speed() -> None:
    time, theta, velocity = _run()
    frame = replace(_frame(time, theta, velocity), direction=np.where(time < 30.0, 1.0, 0.0))
    values = 1e-5 * np.sin(40.0 * theta)
    expected = 4e-4 * np.cos(40.0 * theta)
    slope = over_angle(values, frame)
    moving = (time > 0.1) & (time < 29.9)
    np.testing.assert_allclose(slope[moving], expected[moving], atol=4e-6)
    assert not slope[time >= 30.0].any()


def test_the_steps_of_the_steady_response_are_those_of_all_orders_together() -> None:
    rng = np.random.default_rng(3)
    steady = rng.normal(size=(50, 3)) + 1j * rng.normal(size=(50, 3))
    steady[10:14, 1] = 0.0
    speed, angle = rng.uniform(0.1, 0.4, 50), rng.uniform(0.0, 20.0, 49)
    deflection, velocity = _steps(steady, speed, angle, ORDERS)
    wave = np.exp(1j * angle[:, None] * ORDERS)
    rate = steady * 1j * speed[:, None] * ORDERS
    np.testing.assert_allclose(deflection, np.sum(-np.diff(steady, axis=0) * wave, axis=1).imag, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(velocity, np.sum(-np.diff(rate, axis=0) * wave, axis=1).imag, rtol=0.0, atol=1e-10)


def test_an_order_without_a_number_makes_its_steps_none() -> None:
    steady = np.ones((4, 3), dtype=np.complex128)
    steady[2, 1] = np.nan
    deflection, velocity = _steps(steady, np.array([0.1, 0.2, 0.3, 0.4]), np.array([0.3, 0.4, 0.5]), ORDERS)
    assert np.isnan(deflection).tolist() == np.isnan(velocity).tolist() == [False, True, True]
