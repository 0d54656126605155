"""How the load is shaken by waves of the transmission error that no window of an acceleration lets pass."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.recordings.shaking import shaken
from bench.simulation.frame import FloatArray

RATE, SIZE, SPEED = 1000.0, 60_000, 0.9
ORDER, SIZE_RAD, NOISE = 277.0, 8e-6, 1e-6
TIME = np.arange(SIZE) / RATE
ANGLE, SPEEDS = SPEED * TIME, np.full(SIZE, SPEED)
PERIODS = slice(0, round(1200 * 2.0 * np.pi / (ORDER * SPEED) * RATE))
"""a piece of so many whole periods of the wave"""


def wave() -> FloatArray:
    """A wave of the transmission error at the samples (n,), rad."""
    return np.asarray(SIZE_RAD * np.sin(ORDER * ANGLE + 0.4))


def noise(seed: int, size: float = NOISE) -> FloatArray:
    """White noise at the samples (n,), rad."""
    return np.random.default_rng(seed).normal(0.0, size, SIZE)


def rms(values: FloatArray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("speed", [0.3, 0.9])
def test_a_wave_in_noise_has_the_acceleration_of_its_order_and_the_speed(speed: float) -> None:
    true = -((ORDER * speed) ** 2) * wave()
    found = shaken(ANGLE, wave() + noise(1), np.full(SIZE, speed), [PERIODS])
    assert rms((found - true)[PERIODS]) < 0.05 * rms(true)


def test_noise_alone_shakes_nothing() -> None:
    found = [rms(shaken(ANGLE, noise(seed), SPEEDS, [slice(0, SIZE)])) for seed in range(4)]
    assert max(found) < 1e-6 * (ORDER * SPEED) ** 2 * NOISE


def test_only_steady_pieces_are_shaken() -> None:
    pieces = [slice(5_000, 25_000), slice(30_000, 50_000)]
    found = shaken(ANGLE, wave() + noise(2), SPEEDS, pieces)
    inside = np.zeros(SIZE, dtype=bool)
    for piece in pieces:
        inside[piece] = True
        assert found[piece].any()
    assert not found[~inside].any()


def test_a_piece_of_a_few_samples_is_not_looked_at() -> None:
    assert not shaken(ANGLE, wave(), SPEEDS, [slice(0, 199), slice(300, 400)]).any()
    assert shaken(ANGLE, wave(), SPEEDS, [slice(0, 400)]).any()


def test_a_piece_with_a_value_that_is_no_number_is_not_looked_at() -> None:
    left = wave() + noise(3)
    left[1000] = np.nan
    assert not shaken(ANGLE, left, SPEEDS, [slice(0, SIZE)]).any()


def test_where_nothing_turns_nothing_is_shaken() -> None:
    assert not shaken(np.zeros(SIZE), wave(), np.zeros(SIZE), [slice(0, SIZE)]).any()
