"""Rows of recordings by channel: in a heating run no transmission error is compared, but its states go on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.mismatch.recordings.collected import Collected
from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.prepared import Folder, prepare
from bench.recording import ChannelSpec, Recording, Segment, write_recording
from bench.simulation.quantities import quantity
from bench.simulation.terms import TRANSMISSION_ERROR
from tests.bench.recording import builders

RATE, SIZE, LOAD = 200.0, 8000, 20.0
TIME = np.arange(SIZE) / RATE
NAMES = frozenset({TRANSMISSION_ERROR})
MANNER = Manner(0.5, 0.06, 1000.0)


def read(folder: Path, kinds: tuple[str, ...]) -> Collected:
    """Recordings of such kinds under one load, one after another."""
    out = Collected()
    for number, kind in enumerate(kinds):
        rng = np.random.default_rng(number)
        values = {"time": TIME, "motor_angle": 18.5 * TIME, "load_angle": 0.1 * TIME + rng.normal(0.0, 1e-6, SIZE)}
        values["load_torque"] = np.full(SIZE, LOAD)
        channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
        header = builders.header(f"r{number}", sample_rate=RATE, kind=kind)
        write_recording(folder / f"r{number}.h5", header, channels, [Segment("steady", 0, SIZE)], [])
        recording = Recording.open(folder / f"r{number}.h5")
        begun = recording.started_at.timestamp() - number * SIZE / RATE
        out.add(prepare(recording, number, Folder(begun, MANNER, ()), group=1), NAMES, MANNER)
    return out


def test_states_of_the_transmission_error_go_on_through_a_heating_run(tmp_path: Path) -> None:
    rows = read(tmp_path, ("constant_velocity", "heating", "constant_velocity")).joined(TRANSMISSION_ERROR)
    assert set(rows.frame.recording) == {0, 2}
    assert rows.frame.aside is not None
    assert set(rows.frame.aside.recording) == {1}
    came = quantity("impulse_25000Nms", rows.frame)
    begins = came[np.searchsorted(rows.frame.recording, 2)]
    assert begins == pytest.approx(2.0 * LOAD * SIZE / RATE, rel=0.02)


def test_a_heating_run_alone_has_no_transmission_error_to_compare(tmp_path: Path) -> None:
    assert TRANSMISSION_ERROR not in read(tmp_path, ("heating",)).rows
