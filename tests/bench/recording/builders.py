"""Recordings for tests: small, of the shape the bench writes, with known content."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.recording import ChannelSpec, Event, Gearbox, RecordingHeader, Segment, Setpoint, write_recording

SAMPLE_RATE = 2000.0
COUNTS_PER_TURN = 1 << 25


def header(recording_id: str = "p001-1", **changes: Any) -> RecordingHeader:
    values: dict[str, Any] = {
        "recording_id": recording_id,
        "campaign_id": "c1",
        "kind": "constant_velocity",
        "started_at": datetime(2026, 11, 21, 9, 0, 0, tzinfo=UTC),
        "sample_rate": SAMPLE_RATE,
        "source": "emulator",
        "setpoint": Setpoint(load_torque=500.0, velocity=0.1, temperature=30.0),
        "gearbox": Gearbox(185.0, 24, 96, 45, 46),
        "point_id": "p001",
        "take": 1,
        "zero_id": "zero-1",
        "config": "[bench]\nname = 'test'\n",
        "software": {"name": "gearbench", "version": "0", "revision": "abc"},
    }
    return RecordingHeader(**(values | changes))


def specs() -> list[ChannelSpec]:
    return [
        ChannelSpec.of("time", dtype="int64", scale=1 / SAMPLE_RATE),
        ChannelSpec.of("motor_angle", scale=2 * math.pi / 8192, origin="input_drive/0x6064"),
        ChannelSpec.of("load_angle", scale=2 * math.pi / COUNTS_PER_TURN, origin="load_drive/0x6064"),
        ChannelSpec.of("motor_velocity", scale=1e-3),
        ChannelSpec.of("motor_torque", scale=0.0175),
        ChannelSpec.of("load_torque", scale=10000 / 32768, offset=1.5),
        ChannelSpec.of("load_motor_torque", scale=3.3),
        ChannelSpec.of("temperature", scale=0.1),
        ChannelSpec.of("cycle"),
    ]


def columns(start: int, stop: int, *, turns_per_s: float = 2.0) -> dict[str, NDArray[Any]]:
    """Rows ``start`` to ``stop`` of an endless recording; fast enough for a revolution in half a second."""
    index = np.arange(start, stop, dtype=np.int64)
    load = np.round(index * (turns_per_s * COUNTS_PER_TURN / SAMPLE_RATE)).astype(np.int64)
    return {
        "time": index,
        "motor_angle": load * 185 // (COUNTS_PER_TURN // 8192),
        "load_angle": load,
        "motor_velocity": (index % 11 - 5 + 2_324_000).astype(np.int32),
        "motor_torque": (index * 7 % 13 - 3).astype(np.int16),
        "load_torque": (index * 5 % 101 + 1600).astype(np.int16),
        "load_motor_torque": (index % 17 + 150).astype(np.int16),
        "temperature": (index // 1000 + 300).astype(np.int16),
        "cycle": index + 12345,
    }


def write(path: Path, rows: int = 3000, **changes: Any) -> Path:
    """Write a recording that meets the format in every point."""
    data = columns(0, rows)
    write_recording(
        path,
        header(changes.pop("recording_id", path.stem), **changes),
        {spec.name: (data[spec.name], spec) for spec in specs()},
        [Segment("ramp_up", 0, min(100, rows)), Segment("steady", min(100, rows), rows)],
        [Event(0.5, "info", "operator: lubricant topped up")],
        accepted=True,
        quality={"passed": True},
    )
    return path
