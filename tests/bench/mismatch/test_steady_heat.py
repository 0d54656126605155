"""The temperature that effects depend on is that of a lubricant, without the noise of its thermometer."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.prepared import Folder, prepare
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
    """Ten minutes are lost, in which the gearbox has cooled down."""
    half = SIZE // 2
    time = np.concatenate([TIME[:half], TIME[half:] + 600.0])
    level = np.where(np.arange(SIZE) < half, 36.0, 31.0)
    read, _ = as_read(tmp_path, level, time)
    assert np.allclose(read, level)
