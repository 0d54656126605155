"""Rows of the temperature: what rounding they have, and how far apart they lie."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.prepared import Folder, prepare
from bench.mismatch.recordings.rows import heat_rows, step_of
from bench.recording import ChannelSpec, Recording, Segment, write_recording
from bench.simulation.frame import FloatArray
from bench.simulation.memory import integral
from tests.bench.recording import builders

FOLDER = Folder(builders.header("r").started_at.timestamp(), Manner(0.5, 0.06, 1000.0))
RATE = 100.0


def read(folder: Path, temperature: FloatArray) -> Recording:
    """A recording of a motor that turns steadily, with the readings of its thermometer."""
    time = np.arange(temperature.size) / RATE
    values = {"time": time, "motor_angle": 18.5 * time, "motor_torque": 0.5 + 0.0 * time, "temperature": temperature}
    channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
    header = builders.header("r", sample_rate=RATE)
    write_recording(folder / "r.h5", header, channels, [Segment("steady", 0, time.size)], [])
    return Recording.open(folder / "r.h5")


@pytest.mark.parametrize("step", [0.1, 0.01, 0.5])
def test_the_step_is_that_between_readings(step: float) -> None:
    drifting = 23.0 + np.linspace(0.0, 5.0 * step, 1000) + np.random.default_rng(1).normal(0.0, step, 1000)
    assert step_of(step * np.round(drifting / step)) == pytest.approx(step)


def test_no_step_is_seen_in_numbers_that_all_differ_or_never_do() -> None:
    assert step_of(np.random.default_rng(2).normal(size=500)) == 0.0
    assert step_of(np.full(500, 23.1)) == 0.0
    assert step_of(np.zeros(0)) == 0.0
    # a scaled integer is known to sixteen digits
    assert step_of(np.repeat([23.1, 23.1 * (1.0 + 1e-15), 23.2], 100)) == pytest.approx(0.1)


@pytest.mark.parametrize("size", [6000, 6030, 6190])
def test_cooling_is_integrated_between_the_middles_of_rows(tmp_path: Path, size: int) -> None:
    """The last row may be as short as a reading."""
    rows = heat_rows(prepare(read(tmp_path, np.full(size, 45.0)), 0, FOLDER))
    warmth = integral(rows.frame.temperature, rows.frame)
    assert warmth == pytest.approx(45.0 * (rows.frame.elapsed - rows.frame.elapsed[0]))


@pytest.mark.parametrize(("step", "scatter"), [(0.1, 1e-4), (0.01, 0.03)])
def test_a_row_is_as_uncertain_as_the_rounding_at_least(tmp_path: Path, step: float, scatter: float) -> None:
    warm = 23.02 + np.random.default_rng(3).normal(0.0, scatter, 6000)
    recording = read(tmp_path, step * np.round(warm / step))
    within = heat_rows(prepare(recording, 0, FOLDER)).within
    # on one step alone nothing says how large it is
    expected = scatter**2 + step**2 / 12.0 if scatter > step else 0.0
    assert float(np.median(within)) == pytest.approx(expected, rel=0.1, abs=1e-12)
