"""A small machine in motion, and simulations of it that other people might have."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from bench.recording import ChannelSpec, Gearbox, RecordingHeader, Segment, Setpoint, write_recording
from bench.simulation.frame import FloatArray

RATE = 100.0
RATIO = 50.0
SECONDS = 10.0
NOISE = 0.004
F_C, F_V, F_S, W_S = 0.30, 0.010, 0.20, 3.0
"""Coulomb N·m, viscous N·m·s/rad, Stribeck N·m and its speed rad/s, at the motor"""
SPEEDS = (0.5, 1.0, 2.0, 4.0, 7.0, 12.0, 20.0, 30.0)
BEGIN = datetime(2026, 1, 1, tzinfo=UTC)


def friction(speed: FloatArray | float, f_c: float = F_C, f_v: float = F_V) -> Any:
    """What the simulations know: N·m at a motor's speed in rad/s."""
    return f_c * np.sign(speed) + f_v * speed


def joint(recording: Any, f_c: float = F_C, f_v: float = F_V) -> dict[str, Any]:
    """As a Python function; its numbers may be recalibrated."""
    return {"motor_torque": friction(recording.motor_velocity.to_numpy(), f_c, f_v)}


def record(folder: Path, stribeck: float = 0.0, simulated: dict[str, float] | None = None, f_c: float = F_C) -> Path:
    """Recordings of steady motion in both directions; with channels ``simulated`` elsewhere with other numbers."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, (speed, sign) in enumerate((s, d) for s in SPEEDS for d in (1.0, -1.0)):
        rng = np.random.default_rng(number)
        n = int(RATE * SECONDS)
        time = np.arange(n) / RATE
        motion = sign * speed * (1.0 + 0.05 * np.sin(0.7 * time))
        angle = np.cumsum(motion) / RATE
        torque = friction(motion, f_c) + stribeck * sign * np.exp(-((motion / W_S) ** 2)) + rng.normal(0, NOISE, n)
        values = {"time": time, "motor_angle": angle, "motor_velocity": motion, "motor_torque": torque}
        channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
        if simulated is not None:
            friction_torque = friction(motion, **simulated)
            channels["simulated/motor_torque"] = (friction_torque, ChannelSpec("simulated/motor_torque", "N·m"))
        header = RecordingHeader(
            recording_id=f"r{number:02d}",
            campaign_id="machine",
            kind="constant_velocity",
            started_at=BEGIN + timedelta(minutes=number),
            sample_rate=RATE,
            source="import",
            setpoint=Setpoint(np.nan, sign * speed / RATIO, np.nan),
            gearbox=Gearbox(RATIO),
        )
        write_recording(folder / f"r{number:02d}.h5", replace(header), channels, [Segment("steady", 0, n)])
    return folder
