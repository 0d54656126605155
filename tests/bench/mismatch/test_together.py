"""Several folders as one data set: one gearbox, one encoder zero, every recording once."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.mismatch.many import tasks_of
from bench.mismatch.recordings.loading import load
from bench.mismatch.recordings.source import gathered
from bench.recording import write_recording
from bench.recording.header import ChannelSpec, Gearbox, RecordingHeader, Segment, Setpoint

RATE = 200.0
ZERO, SERIAL = "zero-1", "380-0007"


def folder(where: Path, hour: int, zero: str | None = ZERO, serial: str | None = SERIAL, count: int = 3) -> Path:
    """A folder of a few recordings, which are called alike in every folder."""
    where.mkdir()
    for number in range(count):
        write(where, number, hour, zero, serial)
    return where


def write(where: Path, number: int, hour: int, zero: str | None, serial: str | None) -> None:
    """A recording at constant speed."""
    n = int(20 * RATE)
    time = np.arange(n) / RATE
    speed = 0.1 * (-1.0) ** number
    rng = np.random.default_rng([hour, number])
    values = {
        "time": time,
        "motor_angle": 185.0 * speed * time,
        "motor_torque": 0.5 * np.sign(speed) + rng.normal(0.0, 0.02, n),
        "load_torque": rng.normal(0.0, 1.0, n),
        "load_motor_torque": np.zeros(n),
    }
    header = RecordingHeader(
        recording_id=f"{number:04d}-constant_velocity",
        campaign_id="c",
        kind="constant_velocity",
        started_at=datetime(2026, 1, 1, hour, number, tzinfo=UTC),
        sample_rate=RATE,
        source="emulator",
        setpoint=Setpoint(0.0, speed, 25.0),
        gearbox=Gearbox(185.0, 24, 96, 45, 46),
        zero_id=zero,
        gearbox_serial=serial,
    )
    channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
    write_recording(where / f"{header.recording_id}.h5", header, channels, [Segment("steady", 0, n)], [])


def test_two_folders_are_one_data_set(tmp_path: Path) -> None:
    first, second = folder(tmp_path / "morning", 6), folder(tmp_path / "evening", 18)
    both = load([second, first])
    names = [m.name for m in both.members]
    assert len(set(names)) == 6
    assert names[:3] == [f"morning/{k:04d}-constant_velocity" for k in range(3)]
    assert {m.name.split("/")[0] for m in both.members[3:]} == {"evening"}
    # the distance run goes on from one to the other
    travelled = [both.travelled[str(m.recording.path)] for m in both.members]
    assert travelled == sorted(travelled)
    assert travelled[-1] == pytest.approx(5 * 0.1 * 20.0, rel=0.01)
    # alone, a recording is called by its id
    assert {m.name.split(" ")[0] for m in load(first).members} == {f"{k:04d}-constant_velocity" for k in range(3)}


@pytest.mark.parametrize(
    ("other", "reason"),
    [({"zero": "zero-2"}, "encoder zero zero-1.*has zero-2"), ({"serial": "380-0008"}, "gearbox 380-0007.*380-0008")],
)
def test_other_gearboxes_and_zeros_are_refused(tmp_path: Path, other: dict[str, str], reason: str) -> None:
    first, second = folder(tmp_path / "a", 6), folder(tmp_path / "b", 18, **other)  # type: ignore[arg-type]
    with pytest.raises(ConfigurationError, match=reason):
        gathered([first, second])


def test_a_folder_counts_once(tmp_path: Path) -> None:
    first = folder(tmp_path / "a", 6)
    with pytest.raises(ConfigurationError, match="is named twice"):
        gathered([first, tmp_path / "." / "a"])


def test_together_is_one_task(tmp_path: Path) -> None:
    paths = [tmp_path / "a", tmp_path / "b"]
    (task,) = tasks_of(paths, tmp_path / "out", together=True)
    assert task.recordings == tuple(paths)
    assert task.out == tmp_path / "out"
