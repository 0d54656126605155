"""A kept load without the noise of its sensor; how much of it the load motor confirms."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bench.mismatch.recordings.level import confirmed, kept_segments, levelled
from bench.recording import ChannelSpec, Recording, Segment, write_recording
from tests.bench.recording import builders

RATE, SIZE, LARGEST = 100.0, 6000, 1000.0


def slow(rng: np.random.Generator, size: int, sigma: float, memory: float) -> np.ndarray:
    """Noise of a correlation time ``memory`` s at :data:`RATE`."""
    keep = np.exp(-1.0 / (memory * RATE))
    out = np.empty(size)
    out[0] = rng.normal(0.0, sigma)
    for k in range(1, size):
        out[k] = keep * out[k - 1] + np.sqrt(1.0 - keep**2) * rng.normal(0.0, sigma)
    return out


def recordings(folder: Path, real: float, noise: float) -> list[Recording]:
    """Recordings of a load that wavers by ``real`` N·m, read by a sensor that wavers by ``noise`` N·m."""
    rng = np.random.default_rng(3)
    made = []
    for number in range(4):
        load = 500.0 + slow(rng, SIZE, real, 2.0)
        data = {
            "time": np.arange(SIZE) / RATE,
            "load_torque": load + slow(rng, SIZE, noise, 2.0),
            "load_motor_torque": load + rng.normal(0.0, 1.0, SIZE),
        }
        units = {"time": "s", "load_torque": "N·m", "load_motor_torque": "N·m"}
        specs = {name: ChannelSpec(name, unit) for name, unit in units.items()}
        path = folder / f"r{number}.h5"
        header = builders.header(path.stem, sample_rate=RATE)
        write_recording(path, header, {n: (data[n], specs[n]) for n in data}, [Segment("steady", 0, SIZE)], [])
        made.append(Recording.open(path))
    return made


def test_what_the_load_motor_does_not_feel_is_noise_of_the_sensor(tmp_path: Path) -> None:
    assert confirmed(recordings(tmp_path, 0.01, 3.0), LARGEST) < 0.1


def test_a_load_that_wavers_is_kept(tmp_path: Path) -> None:
    assert confirmed(recordings(tmp_path, 3.0, 0.1), LARGEST) > 0.9


def test_of_a_load_and_noise_alike_half_is_kept(tmp_path: Path) -> None:
    assert 0.3 < confirmed(recordings(tmp_path, 3.0, 3.0), LARGEST) < 0.7


def test_without_a_second_witness_the_sensor_is_believed() -> None:
    assert confirmed([], LARGEST) == 1.0


def test_only_the_confirmed_share_is_about_the_level() -> None:
    rng = np.random.default_rng(1)
    torque = 500.0 + slow(rng, SIZE, 3.0, 5.0)
    label, rests = np.zeros(SIZE, dtype=np.int64), np.ones(SIZE, dtype=bool)
    kept = kept_segments(torque, label, rests, LARGEST, RATE)
    believed, level = levelled(torque, kept, RATE)
    half, _ = levelled(torque, kept, RATE, 0.5)
    assert np.ptp(level) == 0.0
    assert np.allclose(half - level, 0.5 * (believed - level))


def test_of_what_a_torque_does_within_the_seconds_only_what_another_does_as_well_is_load() -> None:
    rng = np.random.default_rng(2)
    wavering, noise = slow(rng, SIZE, 3.0, 0.3), rng.normal(0.0, 1.0, (2, SIZE))
    label, rests = np.zeros(SIZE, dtype=np.int64), np.ones(SIZE, dtype=bool)

    def left(load: np.ndarray, beside: np.ndarray | None) -> float:
        torque = 500.0 + load + noise[0]
        smooth, _ = levelled(torque, kept_segments(torque, label, rests, LARGEST, RATE), RATE, beside=beside)
        return float(np.std(500.0 + load - smooth))

    quiet = np.zeros(SIZE)
    # the load that wavers is followed, noise that only one of two reads is not
    assert left(wavering, 500.0 + wavering + noise[1]) < 0.45 * left(wavering, None)
    assert left(quiet, 500.0 + noise[1]) < 1.2 * left(quiet, None)


def test_a_ramp_has_no_level() -> None:
    torque = np.linspace(0.0, 900.0, SIZE)
    label, rests = np.zeros(SIZE, dtype=np.int64), np.ones(SIZE, dtype=bool)
    believed, level = levelled(torque, kept_segments(torque, label, rests, LARGEST, RATE), RATE, 0.0)
    assert np.array_equal(level, torque)
    assert np.array_equal(believed, torque)


def test_a_shaft_that_hums_keeps_its_load() -> None:
    hum = 50.0 * np.sin(2.0 * np.pi * 17.4 * np.arange(SIZE) / RATE)
    label, rests = np.zeros(SIZE, dtype=np.int64), np.ones(SIZE, dtype=bool)
    level = levelled(500.0 + hum, kept_segments(500.0 + hum, label, rests, LARGEST, RATE), RATE)[1]
    assert np.ptp(level) == 0.0
    ramp = np.linspace(0.0, 900.0, SIZE) + hum
    assert np.array_equal(levelled(ramp, kept_segments(ramp, label, rests, LARGEST, RATE), RATE)[1], ramp)
