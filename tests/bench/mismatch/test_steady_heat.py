"""The temperature that effects depend on is that of a lubricant, without the noise of its thermometer."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.prepared import Folder, _of_lubricant, prepare
from bench.recording import ChannelSpec, Recording, Segment, write_recording
from bench.simulation.frame import FloatArray
from tests.bench.recording import builders

RATE, SIZE, NOISE = 50.0, 6000, 0.04
TIME = np.arange(SIZE) / RATE
WARMING = 30.0 + 6.0 * (1.0 - np.exp(-TIME / 150.0))


def as_read(folder: Path, temperature: FloatArray, time: FloatArray = TIME) -> tuple[FloatArray, FloatArray]:
    """The frame's temperature and the channel that is compared, of a recording with a ``temperature`` (n,)."""
    values = {"time": time, "motor_angle": 18.5 * time, "load_angle": 0.1 * time, "temperature": temperature}
    channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
    path = folder / "r.h5"
    write_recording(path, builders.header("r", sample_rate=RATE), channels, [Segment("steady", 0, time.size)], [])
    recording = Recording.open(path)
    own = Folder(recording.started_at.timestamp(), Manner(0.5, 0.06, 1000.0))
    prepared = prepare(recording, 0, own, group=1)
    return prepared.frame.temperature, prepared.measured["temperature"].samples


def test_noise_of_a_thermometer_that_is_read_four_times_a_second_goes_and_the_course_stays(tmp_path: Path) -> None:
    noise = np.repeat(np.random.default_rng(5).normal(0.0, NOISE, SIZE // 12 + 1), 12)[:SIZE]
    read, compared = as_read(tmp_path, WARMING + noise)
    inner = slice(int(20 * RATE), -int(20 * RATE))
    assert np.std((read - WARMING)[inner]) < 0.2 * NOISE
    assert np.abs(read - WARMING).max() < 1.5 * NOISE
    # what is compared with the simulation is the reading itself
    assert np.array_equal(compared, WARMING + noise)


def test_it_is_not_smoothed_over_lost_cycles(tmp_path: Path) -> None:
    """Ten minutes are lost again and again, in which the gearbox has cooled down or warmed up; what is left between is
    shorter than what is smoothed.
    """
    number = np.arange(SIZE) // 600
    level = np.array([36.0, 31.0, 40.0, 25.0, 33.0, 28.0, 30.0, 35.0, 27.0, 38.0])[number]
    read, _ = as_read(tmp_path, level, TIME + 600.0 * number)
    assert np.allclose(read, level)


def test_readings_too_far_apart_to_be_smoothed_stay_as_they_are() -> None:
    time = 10.0 * np.arange(40.0)
    read = np.where(time < 200.0, 30.0, 35.0)
    assert np.array_equal(_of_lubricant(read, time, 0.1), read)
