"""What a law adds that no series without it says: nothing where the monomials say it, else what least squares leave."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.orders.reported_law import of_one_recording
from bench.mismatch.orders.revolutions import Revolution
from bench.mismatch.orders.series import calibrate
from bench.simulation.frame import Frame
from bench.simulation.laws import RESONANCE, Law, factor
from tests.bench.mismatch.report import made

ORDERS = (3.0, 19.0)
SPEEDS, TORQUES = (0.02, 0.05, 0.08, 0.11, 0.17), (-800.0, -200.0, 500.0, 900.0)
EACH = 600
RESONANT = Law(RESONANCE, "second_order", (1.5, 0.1, 0.4), 0.0, ORDERS, np.ones(2))


def campaign() -> Frame:
    """Recordings of one revolution each, either way."""
    frame = made.revolutions(SPEEDS, TORQUES, EACH)
    return replace(frame, temperature=22.0 + frame.recording * 7.0 % 20.0)


def periodic(law: Law) -> Periodic:
    rng = np.random.default_rng(2)
    revolutions = [
        Revolution(0, slice(0, 0), t, side * v, 22.0 + 9.0 * rng.random(), 0.0, side, 1.0, 60.0)
        for side in (1.0, -1.0)
        for v in SPEEDS
        for t in TORQUES
    ]
    load = np.array([[t.torque / 1000.0] for t in revolutions])
    vectors = np.array([[2e-5, 1e-5j]]) * (1.0 + 0.3 * load)
    return Periodic(calibrate(revolutions, vectors, np.full(vectors.shape, 1e-8), ORDERS), laws=(law,))


def test_what_is_left_is_that_of_least_squares_over_the_samples() -> None:
    frame, own = campaign(), periodic(RESONANT)
    number = np.where(frame.recording % 5 == 0, 3.0, 1.0)
    found = own.beyond_series(RESONANT, frame, [number])[0]
    course = own.evaluate(frame)
    left = np.empty(frame.size)
    for side in (1.0, -1.0):
        rows = frame.direction == side
        x = np.column_stack([frame.torque, frame.velocity, frame.temperature])[rows]
        z = (x - x.mean(axis=0)) / x.std(axis=0)
        powers = [z[:, i] * z[:, k] for i in range(3) for k in range(i, 3)] + [*z.T, np.ones(len(z))]
        waves = [w(f * frame.theta[rows]) for f in ORDERS for w in (np.cos, np.sin)]
        columns = np.column_stack([p * w for p in powers for w in waves])
        weight = np.sqrt(number[rows])
        best = np.linalg.lstsq(columns * weight[:, None], course[rows] * weight, rcond=None)[0]
        left[rows] = course[rows] - columns @ best
    assert np.sqrt(np.mean(left**2)) > 1e-6
    np.testing.assert_allclose(found, left, atol=1e-3 * np.abs(left).max())


def test_of_an_order_that_the_simulation_has_not_all_that_the_law_adds_is_left() -> None:
    frame, own = campaign(), periodic(RESONANT)
    number = np.ones(frame.size)
    found = own.beyond_series(RESONANT, frame, [number], known=())[0]
    x = np.column_stack([frame.torque, frame.velocity, frame.temperature])
    without = replace(own, laws=()).series.vectors(x, frame.last_direction)
    more = without * (factor(RESONANT, x, frame.time, ORDERS) - 1.0)
    expected = np.sum(np.imag(more * np.exp(1j * frame.theta[:, None] * np.asarray(ORDERS))), axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    one = own.beyond_series(RESONANT, frame, [number], known=ORDERS[:1])[0]
    assert np.sqrt(np.mean(found**2)) > np.sqrt(np.mean(one**2)) > 0.0


def test_a_law_that_the_monomials_say_adds_nothing() -> None:
    frame = campaign()
    # far below its natural frequency a stiff mode follows: what it adds grows with the square of the speed
    slow = replace(RESONANT, point=(400.0, 0.0, 0.4))
    own = periodic(slow)
    assert factor(slow, np.array([[0.0, 0.17, 25.0]]), np.zeros(1), ORDERS)[0] == pytest.approx(1.0, abs=1e-3)
    assert np.abs(own.beyond_series(slow, frame, [np.ones(frame.size)])[0]).max() < 1e-9


def test_a_law_of_one_recording_is_none() -> None:
    recording = np.repeat(np.arange(5), 10)
    assert of_one_recording(np.where(recording == 3, 1.0, 0.1), recording)
    assert not of_one_recording(np.where(recording >= 3, 1.0, 0.1), recording)
