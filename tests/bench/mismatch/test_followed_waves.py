"""Whether the load torque follows the waves of the transmission error."""

from __future__ import annotations

from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

from bench.mismatch.recordings.followed_waves import FEWEST, are_followed, folder_of
from bench.mismatch.recordings.prepared import prepare
from bench.recording import ChannelSpec, Recording, Segment, write_recording
from bench.simulation.frame import FloatArray
from tests.bench.recording import builders

RATE, RATIO, INERTIA, ORDER = 500.0, 185.0, 3.0, 276.0


def recorded(folder: Path, follows: bool, number: int = 8) -> list[Recording]:
    """Motions that start, run steadily and stop at some speeds, on a gearbox with one large order; the load torque has
    the inertia times the output's acceleration, or times that of both shafts.
    """
    rng, out = np.random.default_rng(3), []
    time = np.arange(4000) / RATE
    for k in range(number):
        speed = 0.5 + 0.05 * k
        rate = speed * np.clip(np.minimum(time, time[-1] - time) / 0.5, 0.0, 1.0)
        theta = np.cumsum(rate) / RATE
        error = 2e-5 * np.sin(ORDER * theta)
        together, waves = np.gradient(rate, time), np.gradient(np.gradient(error, time), time)
        torque = 5.0 + INERTIA * (together + (waves if follows else 0.0)) + rng.normal(0.0, 0.3, time.size)
        values = {
            "time": time,
            "motor_angle": RATIO * theta,
            "load_angle": theta + error + rng.normal(0.0, 1e-7, time.size),
            "load_torque": torque,
            "load_motor_torque": np.zeros(time.size),
        }
        channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
        path = folder / f"r{k:02d}.h5"
        started = builders.header().started_at + timedelta(minutes=k)
        header = builders.header(path.stem, sample_rate=RATE, started_at=started)
        write_recording(path, header, channels, [Segment("steady", 300, 3700)], [])
        out.append(Recording.open(path))
    return out


def waves_of(recording: Recording, recordings: list[Recording]) -> float:
    """Root mean square of the load's acceleration in the middle of a recording, as it is prepared."""
    frame = prepare(recording, 0, folder_of(recordings), group=1).frame
    middle: FloatArray = frame.load_acceleration[1000:3000]
    return float(np.sqrt(np.mean(middle**2)))


@pytest.mark.parametrize("follows", [True, False])
def test_the_load_is_accelerated_as_its_torque_says(tmp_path: Path, follows: bool) -> None:
    recordings = recorded(tmp_path, follows)
    assert folder_of(recordings).manner.waves is follows
    size = 2e-5 * (ORDER * 0.5) ** 2 / np.sqrt(2.0)
    found = waves_of(recordings[0], recordings)
    assert found == pytest.approx(size, rel=0.2) if follows else found < 0.1 * size


def test_few_recordings_are_no_witness(tmp_path: Path) -> None:
    assert folder_of(recorded(tmp_path, False, FEWEST - 1)).manner.waves


def test_waves_that_nothing_shows_are_believed() -> None:
    """Noise in the torque, the two accelerations the same but for a little."""
    rng = np.random.default_rng(1)
    shown = []
    for _ in range(12):
        shafts = rng.normal(size=2000)
        shown.append((2.0 * shafts + 30.0 * rng.normal(size=2000), shafts + 0.01 * rng.normal(size=2000), shafts))
    assert are_followed(shown)
