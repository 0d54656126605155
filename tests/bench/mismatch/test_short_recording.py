"""Recordings of a few samples are read, whatever they tell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.prepared import Folder, prepare
from bench.recording import ChannelSpec, Recording, Segment, write_recording
from tests.bench.recording import builders

RATE = 500.0


@pytest.mark.parametrize("size", [1, 2, 3, 5, 8])
def test_a_recording_of_a_few_samples_is_prepared(tmp_path: Path, size: int) -> None:
    time = np.arange(size) / RATE
    values = {"time": time, "motor_angle": 18.5 * time, "load_angle": 0.1 * time, "temperature": np.full(size, 30.0)}
    channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
    path = tmp_path / "r.h5"
    write_recording(path, builders.header("r", sample_rate=RATE), channels, [Segment("steady", 0, size)], [])
    recording = Recording.open(path)
    own = Folder(recording.started_at.timestamp(), Manner(0.5, 0.06, 1000.0))
    frame = prepare(recording, 0, own, group=1).frame
    assert frame.size == size
    assert np.allclose(frame.temperature, 30.0)
