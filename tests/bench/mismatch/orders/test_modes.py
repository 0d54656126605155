"""A resonance that the orders pass: what it does to them in either direction, and that it is found, weak or strong."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import freqs

from bench.mismatch.orders.law_scores import Amplitudes, factors
from bench.mismatch.orders.modes import Bounds, begun, beyond_noise, refined
from bench.mismatch.orders.revolutions import Revolution
from bench.mismatch.orders.series import calibrate
from bench.simulation.laws import MODES, RESONANCE, Law, Reference, factor

ORDERS = (1.0, 3.0, 9.0, 19.0, 27.0, 46.0, 92.0, 138.0, 184.0, 276.0)
SPEEDS = (0.04, 0.06, 0.085, 0.11, 0.13, 0.17)
LOADS = (-800.0, 0.0, 800.0)
NOISE = 2e-8
NATURAL, DAMPING = 9.0, 0.08


def swung(form: str, order: float, speed: float) -> complex:
    """Vector of an order's wave of size 1 on a mass on a spring, by integration over time: either the wave is the far
    end of the spring, or the base that the mass sits on, against which it is measured.
    """
    w = order * speed

    def rate(t: float, y: Any) -> list[float]:
        drive = w**2 * np.sin(w * t) if form == "second_order_of_base" else NATURAL**2 * np.sin(w * t)
        return [y[1], drive - 2.0 * DAMPING * NATURAL * y[1] - NATURAL**2 * y[0]]

    time = np.linspace(20.0, 20.0 + 4.0 * 2.0 * np.pi / abs(w), 400)
    swing = solve_ivp(rate, (0.0, time[-1]), [0.0, 0.0], t_eval=time, rtol=1e-8, atol=1e-10).y[0]
    if form == "second_order":
        swing -= np.sin(w * time)
    theta = speed * time
    a, b = np.linalg.lstsq(np.column_stack([np.cos(order * theta), np.sin(order * theta)]), swing, rcond=None)[0]
    return complex(b, a)


@pytest.mark.parametrize("form", ["second_order", "second_order_of_base"])
@pytest.mark.parametrize("speed", [0.085, -0.085])
def test_a_mass_on_a_spring_does_what_the_law_says(form: str, speed: float) -> None:
    orders = (27.0, 92.0, 138.0)  # below the resonance, near it, above it
    law = Law(RESONANCE, form, (NATURAL, DAMPING, 0.3), 0.0, orders, np.ones(3))
    told = factor(law, np.array([[0.0, speed, 25.0]]), np.zeros(1), orders)[0]
    swings = np.array([1.0 + 0.3 * swung(form, f, speed) for f in orders])
    np.testing.assert_allclose(told, swings, atol=2e-3)


def passed(form: str, natural: float, damping: float, share: float, seed: int) -> tuple[Any, Amplitudes]:
    """Revolutions at some speeds and loads both ways, whose orders have passed a mode."""
    rng = np.random.default_rng(seed)
    revolutions = [
        Revolution(0, slice(0, 0), load + 30.0 * rng.normal(), side * speed, 25.0 + rng.normal(), 0.0, side, 1.0, 60.0)
        for side in (1.0, -1.0)
        for speed in SPEEDS
        for load in LOADS
    ]
    x = np.array([[t.torque, t.velocity, t.temperature] for t in revolutions])
    size = 10.0 ** rng.uniform(-5.7, -4.7, len(ORDERS)) * np.exp(2j * np.pi * rng.random(len(ORDERS)))
    load = x[:, :1] / 1000.0
    slow = size * (1.0 + 0.2 * load * rng.normal(size=len(ORDERS))) * np.exp(0.2j * load)
    frequency = x[:, 1:2] * np.asarray(ORDERS)
    if form == "second_order_unsigned":
        frequency = np.abs(frequency)
    top = [-1.0, 0.0, 0.0] if form == "second_order_of_base" else [natural**2]
    swing = freqs(top, [1.0, 2.0 * damping * natural, natural**2], frequency.ravel())[1].reshape(frequency.shape)
    if form != "second_order_of_base":
        swing -= 1.0
    vectors = slow * (1.0 + share * swing)
    vectors = vectors + NOISE * (rng.normal(size=vectors.shape) + 1j * rng.normal(size=vectors.shape))
    noise = np.full(vectors.shape, NOISE)
    series = calibrate(revolutions, vectors, noise, ORDERS)
    time = np.arange(len(revolutions), dtype=np.float64)
    direction = np.array([t.direction for t in revolutions])
    data = Amplitudes(vectors, noise, x, direction, time, ORDERS, series, Reference.of(x, time))
    given = SimpleNamespace(orders=ORDERS, notch=())
    return SimpleNamespace(parts=(), training_revolutions=revolutions, given=given), data


@pytest.mark.parametrize("form", MODES)
@pytest.mark.parametrize(("damping", "share"), [(0.05, 0.06), (0.15, 0.5)])
def test_a_mode_is_found_with_its_numbers(form: str, damping: float, share: float) -> None:
    model, data = passed(form, 7.3, damping, share, 4)
    best = refined(cast("Any", model), data, begun(data)[0])
    assert best.law.form == form
    assert best.law.point[0] == pytest.approx(7.3, rel=0.01)
    assert best.law.point[1] == pytest.approx(damping, rel=0.15)
    assert best.law.point[2] == pytest.approx(share, rel=0.1)
    answer = factor(best.law, data.x, data.time, ORDERS)
    left = data.vectors - best.series.vectors(data.x, data.direction) * answer
    assert np.sqrt(np.mean(np.abs(left) ** 2) / 2.0) < 1.5 * NOISE


def test_where_the_orders_pass_no_mode_nothing_is_gained() -> None:
    model, data = passed("second_order", 7.3, 0.1, 0.0, 5)
    assert refined(cast("Any", model), data, begun(data)[0]).gain < 0.0


@pytest.mark.parametrize(
    "wanted", [(1e-4, 0.004, 0.5), (0.02, 0.8, 1.5), (3.0, 1e-3, 0.1), (30.0, 0.05, 0.1), (1e4, 9.0, 9.0)]
)
def test_a_mode_meets_an_order_and_dies_away_within_a_revolution(wanted: tuple[float, float, float]) -> None:
    _, data = passed("second_order", 7.3, 0.1, 0.1, 6)
    natural, damping, _ = Bounds.of(data).clipped(np.log(wanted))
    assert natural >= min(SPEEDS) * min(ORDERS)
    revolution = 2.0 * np.pi / float(np.median(SPEEDS))
    assert np.exp(-natural * damping * revolution) <= 0.0501
    if wanted == (30.0, 0.05, 0.1):  # one that does so anyhow is as it is
        assert (natural, damping) == pytest.approx((30.0, 0.05))


def test_forms_that_say_the_same_one_way_differ_the_other_way() -> None:
    """Where all recordings go one way the first form is told: a mass on a spring."""
    frequency = np.linspace(0.1, 30.0, 200)
    signed, unsigned = MODES["second_order"], MODES["second_order_unsigned"]
    np.testing.assert_array_equal(signed(frequency, 7.3, 0.1), unsigned(frequency, 7.3, 0.1))
    np.testing.assert_allclose(signed(-frequency, 7.3, 0.1), np.conj(unsigned(-frequency, 7.3, 0.1)))
    assert list(MODES).index("second_order") < list(MODES).index("second_order_unsigned")


def test_a_strong_mode_is_told_from_noise_by_the_vectors_alone() -> None:
    """Whatever a series calibrated on them is like: it is not asked."""
    _, data = passed("second_order_of_base", 7.3, 0.06, 0.0, 4)
    moved = [ORDERS.index(f) for f in (46.0, 92.0)]
    frequency = data.x[:, 1:2] * np.asarray(ORDERS)[moved]
    swing = (frequency / 7.3) ** 2 / (1.0 - (frequency / 7.3) ** 2 + 0.12j * frequency / 7.3)
    vectors = data.vectors.copy()
    vectors[:, moved] *= 1.0 + 0.6 * np.exp(1j) * swing
    found = beyond_noise(replace(data, vectors=vectors), factors(data), 0, 60, 0.002)
    assert found is not None
    moving, p_value = found
    assert moving.law.orders == (46.0, 92.0)
    assert moving.law.point == pytest.approx((7.3, 0.06), rel=0.1)
    assert p_value < 0.002


@pytest.mark.parametrize("seed", range(8))
def test_noise_moves_no_mode(seed: int) -> None:
    _, data = passed("second_order", 7.3, 0.1, 0.0, seed)
    assert beyond_noise(data, factors(data), seed, 60, 0.002) is None


@pytest.mark.parametrize("quantity", ["temperature", "speed"])
def test_amplitudes_that_follow_another_function_are_no_mode(quantity: str) -> None:
    """Of the third power, which no polynomial of the series says."""
    _, data = passed("second_order", 7.3, 0.1, 0.0, 2)
    value = data.x[:, 2] if quantity == "temperature" else np.abs(data.x[:, 1])
    scaled = (value - value.mean()) / np.ptp(value)
    vectors = data.vectors * (1.0 + 2.0 * scaled[:, None] ** 3)
    assert beyond_noise(replace(data, vectors=vectors), factors(data), 0, 60, 0.002) is None
