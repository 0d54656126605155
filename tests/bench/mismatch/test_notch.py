"""The load motor's ripple is one wave of one size in all recordings: not what the load's inertia or its controller asks
for.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.mismatch.recordings.late import lag_of
from bench.mismatch.recordings.notch import _coherence, _without_inertia, notched
from bench.mismatch.recordings.ripple import ripple_of
from bench.recording import ChannelSpec, Recording, Segment, write_recording
from tests.bench.recording import builders

RATE, SIZE, NOISE = 100.0, 6000, 0.05
SPEEDS = (0.09, 0.1, 0.11, 0.12, 0.13, 0.14, 0.15, 0.17)
"""output, rad/s"""
PAIRS = 45
INERTIA, WAVE = 3.0, 8e-6
"""of the load in kg·m²; amplitude of the transmission error, rad"""
ONE = np.ones(len(SPEEDS))


def recordings(
    folder: Path, ripple: float = 0.0, wave: float = 0.0, wavering: float = 0.0, misread: float = 0.0, lag: float = 0.0
) -> list[Recording]:
    """A load of 500 N·m at each speed: with a ``ripple`` (N·m) of six and twelve times the pole pairs, a ``wave`` (rad)
    of the transmission error at the same orders that shakes the load, and a slow ``wavering`` (N·m) of it.
    ``misread``: a wave that an encoder has there and the load has not, beside one at another order that shakes it.
    ``lag``: s by which the sensor tells the ripple late; every other recording turns backwards where there is one.
    """
    rng = np.random.default_rng(8)
    time = np.arange(SIZE) / RATE
    made = []
    for number, speed in enumerate(SPEEDS):
        speed = -speed if lag and number % 2 else speed
        theta = speed * time
        torque = 500.0 + rng.normal(0.0, NOISE, SIZE)
        error = np.zeros(SIZE)
        for order in (6 * PAIRS, 12 * PAIRS):
            torque += ripple * np.cos(order * (theta - lag * speed) + 0.3)
            error += wave * np.cos(order * theta + 1.1)
            torque -= INERTIA * (order * speed) ** 2 * wave * np.cos(order * theta + 1.1)
        if misread:
            error += misread * np.cos(6 * PAIRS * theta + 1.1) + WAVE * np.cos(200.0 * theta)
            torque -= INERTIA * (200.0 * speed) ** 2 * WAVE * np.cos(200.0 * theta)
        torque += wavering * np.cos(6.0 * theta + rng.uniform(0.0, 2.0 * np.pi))
        values = {"time": time, "motor_angle": 185.0 * theta, "load_angle": theta + error, "load_torque": torque}
        channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
        path = folder / f"r{number}.h5"
        header = builders.header(path.stem, sample_rate=RATE)
        write_recording(path, header, channels, [Segment("steady", 0, SIZE)], [])
        made.append(Recording.open(path))
    return made


def test_a_ripple_of_one_size_at_six_and_twelve_times_the_pole_pairs_is_found(tmp_path: Path) -> None:
    assert ripple_of(recordings(tmp_path, ripple=0.05)).orders == (270.0, 540.0)


@pytest.mark.parametrize("lag", [0.018, -0.007])
def test_how_late_the_sensor_tells_the_ripple_is_read_from_its_phase_at_each_speed(tmp_path: Path, lag: float) -> None:
    seen = ripple_of(recordings(tmp_path, ripple=0.05, lag=lag))
    assert seen.orders == (270.0, 540.0)
    assert seen.lag == pytest.approx(lag, abs=5e-4)


@pytest.mark.parametrize("speeds", [(0.25, -0.25, 0.5, -0.5), (0.5, -0.5), (0.25, 0.5, 0.75, 1.0)])
@pytest.mark.parametrize("lag", [0.004, -0.01, 0.0])
def test_of_lags_that_are_as_good_at_speeds_that_are_multiples_the_smallest_is_taken(
    speeds: tuple[float, ...], lag: float
) -> None:
    """A lag of a whole period between the speeds' differences makes the same vectors."""
    rng = np.random.default_rng(7)
    speed = np.tile(np.array(speeds), 12 // len(speeds))
    orders, one = (270.0, 540.0), rng.uniform(8.0, 12.0, speed.size)
    noise = rng.normal(size=(speed.size, 2)) + 1j * rng.normal(size=(speed.size, 2))
    vectors = one[:, None] * np.exp(1j * (lag * speed[:, None] * np.array(orders) + 0.3)) + 0.3 * noise
    assert lag_of(vectors, one, speed, orders) == pytest.approx(lag, abs=3e-4)


def test_a_ripple_that_is_told_at_once_has_no_lag(tmp_path: Path) -> None:
    assert ripple_of(recordings(tmp_path, ripple=0.05)).lag == 0.0


def test_a_ripple_is_found_beside_waves_that_shake_the_load(tmp_path: Path) -> None:
    assert ripple_of(recordings(tmp_path, ripple=0.05, wave=0.1 * WAVE)).orders == (270.0, 540.0)


def test_what_the_inertia_of_the_load_asks_for_is_no_ripple(tmp_path: Path) -> None:
    assert ripple_of(recordings(tmp_path, wave=WAVE)).orders == ()


def test_what_an_encoder_misreads_is_no_ripple(tmp_path: Path) -> None:
    """Its acceleration is none of the load's: taking off what the inertia would ask for makes a line."""
    assert ripple_of(recordings(tmp_path, misread=WAVE)).orders == ()


def test_a_slow_wavering_of_the_load_is_no_ripple(tmp_path: Path) -> None:
    assert ripple_of(recordings(tmp_path, wavering=0.5)).orders == ()


def test_noise_has_no_ripple(tmp_path: Path) -> None:
    assert ripple_of(recordings(tmp_path)).orders == ()


def test_the_inertia_of_the_load_is_one_number_for_all_orders() -> None:
    rng = np.random.default_rng(3)
    shaken = rng.normal(size=(8, 40)) + 1j * rng.normal(size=(8, 40))
    noise = 0.1 * (rng.normal(size=(8, 40)) + 1j * rng.normal(size=(8, 40)))
    assert np.allclose(_without_inertia(3.0 * shaken + noise, shaken), noise, atol=0.1)


def test_where_no_inertia_is_seen_nothing_is_taken_off() -> None:
    rng = np.random.default_rng(4)
    lines = rng.normal(size=(8, 40)) + 1j * rng.normal(size=(8, 40))
    assert _without_inertia(lines, np.zeros((8, 40), dtype=np.complex128)) is lines
    assert _without_inertia(lines, -lines) is lines


def test_waves_of_one_phase_are_one_ripple_and_those_of_any_phase_are_not() -> None:
    rng = np.random.default_rng(2)
    scatter = 0.2 * (rng.normal(size=ONE.size) + 1j * rng.normal(size=ONE.size))
    assert _coherence(1.0 + scatter, ONE) > 40.0
    assert _coherence(np.exp(2j * np.pi * rng.uniform(size=ONE.size)), ONE) < 10.0
    assert _coherence(scatter, ONE) < 10.0


def test_a_ripple_of_one_size_may_stand_more_or_less_above_the_noise_of_each_recording() -> None:
    rng = np.random.default_rng(5)
    quieter = 1.0 / np.linspace(1.0, 10.0, ONE.size)
    scatter = 0.01 * (rng.normal(size=ONE.size) + 1j * rng.normal(size=ONE.size))
    assert _coherence((2.0 - 1.0j) * quieter + scatter, quieter) > 1000.0


def test_drag_of_a_shaft_that_starts_slowly_is_no_ripple() -> None:
    """Where a shaft starts, waves over its angle are as slow as the drag that grows with the speed."""
    time = np.arange(28.0 * RATE) / RATE
    omega = 190.0 * np.minimum(time, 28.0 - time) / 14.0
    angle = np.cumsum(omega) / RATE / 185.0
    drag = 0.4 + 0.006 * omega + 0.003 * np.gradient(omega, time)
    ripple = 0.02 * np.cos(150.0 * angle + 0.3)
    noise = np.random.default_rng(6).normal(0.0, 0.01, time.size)
    bad, direction = np.zeros(time.size, dtype=bool), np.ones(time.size)
    beside = [omega, np.gradient(omega, time)]
    taken = notched(angle, drag + ripple + noise, direction, bad, (150.0, 300.0), beside)
    assert np.max(np.abs(taken - ripple)) < 0.002
    without = notched(angle, drag + ripple + noise, direction, bad, (150.0, 300.0))
    assert np.max(np.abs(without - ripple)) > 0.02


@pytest.mark.parametrize("slower", [1.0, 0.5])
@pytest.mark.parametrize("turns", [False, True])
def test_the_ripple_beside_a_staircase_of_the_load_is_no_part_of_its_corners(slower: float, turns: bool) -> None:
    """Up and down in steps that last as long as a wave of the lowest order, at one speed or two, one way or both;
    without a load motor nothing else tells.
    """
    rate, orders = 500.0, (150.0, 300.0)
    time = np.arange(int(60 * rate)) / rate
    direction = np.where(turns & (time > 30.0), -1.0, 1.0)
    theta = np.cumsum(0.09 * np.where(time % 20.0 < 12.0, 1.0, slower) * direction) / rate
    ripple = 3.1 * np.cos(150.0 * theta + 0.4) + 1.2 * np.sin(300.0 * theta)
    stairs = np.interp(time % 2.6, [0.0, 0.5, 2.6], [0.0, 1.0, 1.0]) + np.floor(time / 2.6)
    load = 100.0 * np.where(stairs < 11.0, stairs, 22.0 - stairs)
    torque = load + ripple + np.random.default_rng(3).normal(0.0, 1.0, time.size)
    bad = np.zeros(time.size, dtype=bool)
    error, without = (
        float(np.sqrt(np.mean((notched(theta, torque, direction, bad, orders, (), driven) - ripple) ** 2)))
        for driven in (True, False)
    )
    assert error < 0.3
    assert without > 10.0 * error


def test_no_ripple_is_fitted_to_a_handful_of_samples() -> None:
    theta = np.linspace(0.0, 1.0, 300)
    torque = 1000.0 * np.sin(3.0 * theta) + np.cos(150.0 * theta)
    assert not np.any(notched(theta, torque, np.ones(300), np.zeros(300, dtype=bool), (150.0, 300.0), (), driven=True))
