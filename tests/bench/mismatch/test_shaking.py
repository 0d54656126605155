"""How the load is shaken by waves of the transmission error that no window of an acceleration lets pass."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.recordings.shaking import shaken
from bench.mismatch.recordings.smoothing import local_quadratic
from bench.simulation.frame import FloatArray

RATE, SIZE, SPAN = 500.0, 15_000, 0.06
ORDER, SIZE_RAD, NOISE = 277.0, 8e-6, 1e-6
TIME = np.arange(SIZE) / RATE
WHOLE = [slice(0, SIZE)]


def wave(speed: float) -> FloatArray:
    """A wave of the transmission error at the samples (n,), rad."""
    return np.asarray(SIZE_RAD * np.sin(ORDER * speed * TIME + 0.4))


def noise(seed: int) -> FloatArray:
    """White noise at the samples (n,), rad."""
    return np.random.default_rng(seed).normal(0.0, NOISE, SIZE)


def acceleration(
    error: FloatArray,
    speed: float,
    pieces: list[slice],
    count: float = 0.0,
    smoothed: bool = True,
    motor: FloatArray | float = 0.0,
) -> FloatArray:
    """A smoothed acceleration of a motion with an error, and what the pieces' shaking adds: that of the load, or else
    that of the motor, which moves by ``motor`` (n,) beside the even speed.
    """
    alone = np.zeros(SIZE) + motor
    curve = local_quadratic(alone + error if smoothed else alone, RATE, SPAN)[2]
    motion = speed * TIME + alone
    beside = None if smoothed else motion
    return curve + shaken(motion + error, np.full(SIZE, speed), pieces, RATE, SPAN, count, beside)


def rms(values: FloatArray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("smoothed", [True, False])
@pytest.mark.parametrize("speed", [0.25, 0.4, 0.5, 0.9])
def test_a_wave_has_the_acceleration_of_its_order_and_the_speed(speed: float, smoothed: bool) -> None:
    true = -((ORDER * speed) ** 2) * wave(speed)
    found = acceleration(wave(speed) + noise(1), speed, WHOLE, smoothed=smoothed)
    assert rms((found - true)[100:-100]) < 0.12 * rms(true)


@pytest.mark.parametrize("smoothed", [True, False])
def test_what_both_shafts_do_together_counts_once(smoothed: bool) -> None:
    """A drive that hunts at five hertz takes both shafts with it."""
    hertz, size = 5.0, 40e-6
    hunting = size * np.sin(2.0 * np.pi * hertz * TIME)
    true = -((2.0 * np.pi * hertz) ** 2) * hunting
    found = acceleration(noise(6), 0.9, WHOLE, smoothed=smoothed, motor=hunting)
    assert rms((found - true)[200:-200]) < 0.2 * rms(true)


def test_noise_alone_shakes_nothing() -> None:
    for seed in range(20):
        assert not acceleration(noise(seed), 0.9, WHOLE, smoothed=False).any()


def test_only_steady_pieces_are_shaken() -> None:
    pieces = [slice(1_000, 6_000), slice(8_000, 13_000)]
    found = acceleration(wave(0.9) + noise(2), 0.9, pieces, smoothed=False)
    inside = np.zeros(SIZE, dtype=bool)
    for piece in pieces:
        inside[piece] = True
        assert found[piece].any()
    assert not found[~inside].any()


def test_a_piece_of_a_few_samples_is_not_looked_at() -> None:
    assert not acceleration(wave(0.9), 0.9, [slice(0, 599), slice(700, 900)], smoothed=False).any()


def test_a_wave_of_less_than_half_a_count_of_the_encoder_is_none() -> None:
    assert not acceleration(wave(0.9) + noise(3), 0.9, WHOLE, count=20e-6, smoothed=False).any()


def test_a_coarse_encoder_in_even_motion_shakes_nothing() -> None:
    count = 2.0 * np.pi / 2**17
    read = np.round((0.9 * TIME + 0.1 * count * noise(4) / NOISE) / count) * count
    assert not shaken(read, np.full(SIZE, 0.9), WHOLE, RATE, SPAN, count).any()


def test_a_piece_with_a_value_that_is_no_number_is_not_looked_at() -> None:
    broken = 0.9 * TIME + wave(0.9) + noise(3)
    broken[1000] = np.nan
    assert not shaken(broken, np.full(SIZE, 0.9), WHOLE, RATE, SPAN).any()


def test_where_nothing_turns_nothing_is_shaken() -> None:
    assert not shaken(wave(0.9), np.zeros(SIZE), WHOLE, RATE, SPAN).any()
    assert not shaken(1e-7 * TIME + wave(0.9), np.full(SIZE, 1e-7), WHOLE, RATE, SPAN).any()
