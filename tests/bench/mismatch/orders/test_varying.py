"""What an order gains whose amplitude and phase follow the state by polynomials."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.orders.revolutions import Revolution
from bench.mismatch.orders.varying import varying_gain
from bench.mismatch.orders.weak import Stage
from bench.simulation.frame import FloatArray

SIZE, NOISE = 1e-5, 2e-7


def stage(phase: FloatArray, load: FloatArray) -> Stage:
    """Revolutions at some loads (n,), -1 ... 1, that show one order of SIZE with a ``phase`` (n,) in noise."""
    revolutions = tuple(
        Revolution(k, slice(0, 1), 1000.0 * t, 0.1 * (1.0 + k % 3), 25.0 + 0.1 * k, 60.0 * k, 1.0, 1.0, 60.0)
        for k, t in enumerate(load)
    )
    rng = np.random.default_rng(3)
    noise = NOISE * (rng.normal(size=load.size) + 1j * rng.normal(size=load.size))
    vectors = (SIZE * np.exp(1j * phase) + noise)[:, None]
    return Stage(revolutions, vectors, np.ones(load.size), np.array([NOISE]))


@pytest.fixture
def load() -> FloatArray:
    return np.random.default_rng(4).uniform(-1.0, 1.0, 30)


def test_polynomials_say_a_phase_that_turns_far(load: FloatArray) -> None:
    one = stage(2.5 * load, load)
    assert varying_gain(one) > float(one.gains(one.vectors)[0][0]) + 50.0


def test_of_one_vector_they_say_less_than_it_does(load: FloatArray) -> None:
    one = stage(np.zeros(load.size), load)
    plain = float(one.gains(one.vectors)[0][0])
    assert 0.7 * plain < varying_gain(one) < plain


def test_they_say_little_of_a_phase_of_its_own_in_each_revolution(load: FloatArray) -> None:
    told = stage(2.5 * load, load)
    drawn = stage(np.random.default_rng(6).uniform(0.0, 2.0 * np.pi, load.size), load)
    assert varying_gain(drawn) < 0.2 * varying_gain(told)
