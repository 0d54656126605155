"""Steady motion is found where a mapping names no segments."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.importing.cutting import travelled
from bench.importing.steady import FloatArray, steady_stretches
from tests.bench.importing import builders

RATE = 100.0
CHANNELS = 'motor_angle = {variable = "q", unit = "rad"}\nmotor_torque = {variable = "M", unit = "N*m"}'


def turned(speed: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Angle in revolutions of a speed in revolutions a second, and the time."""
    return np.cumsum(speed) / RATE, np.arange(speed.size) / RATE


def found(speed: FloatArray) -> list[slice]:
    angle, time = turned(speed)
    return steady_stretches(angle, travelled(angle, time), time)


def test_a_trapezoid_is_steady_between_its_ramps_in_either_direction() -> None:
    ramp = np.linspace(0.0, 1.0, 200)
    one = np.concatenate([ramp, np.ones(1000), ramp[::-1]])
    first, second = found(np.concatenate([one, -0.5 * one]))
    a_part = 13  # samples, in which a ramp has just begun
    assert first.stop - first.start > 900
    assert 200 - a_part <= first.start < first.stop <= 1200 + a_part
    assert 1600 - 2 * a_part <= second.start < second.stop <= 2600 + 2 * a_part
    assert second.stop - second.start > 800


def test_one_speed_is_steady_from_end_to_end_with_an_encoder_s_noise_and_a_speed_that_wavers() -> None:
    rng = np.random.default_rng(2)
    time = np.arange(3000) / RATE
    angle, _ = turned(1.0 + 0.05 * np.sin(2 * np.pi * 3.0 * time))
    angle = angle + rng.normal(0.0, 1e-4, angle.size)
    (only,) = steady_stretches(angle, travelled(angle, time), time)
    assert only == slice(0, 3000)


@pytest.mark.parametrize(
    "speed",
    [
        np.full(90, 1.0),
        np.sin(2 * np.pi * np.arange(3000) / 300.0),
        np.interp(np.arange(3000), np.arange(0, 3001, 100), np.random.default_rng(4).uniform(-1.0, 1.0, 31)),
        np.random.default_rng(5).normal(0.0, 0.02, 3000),
    ],
    ids=["less than a revolution", "swinging", "ramps only", "standing"],
)
def test_other_motion_is_not(speed: FloatArray) -> None:
    assert not found(speed)


def test_recordings_say_where_they_are_steady_unless_the_mapping_says(tmp_path: Path) -> None:
    time = np.arange(6000) / RATE
    for name in ("found", "named"):
        (tmp_path / name).mkdir()
        builders.csv(tmp_path / name / "a.csv", t=time, q=4.0 * np.pi * time, M=np.ones(time.size))
    done = builders.one(tmp_path / "found", CHANNELS)
    assert [(s.name, s.start, s.stop) for s in done.recording.segments] == [("steady", 0, 6000)]
    assert any("stretches of steady speed, found from the angle" in note for note in done.notes)
    imported = builders.one(tmp_path / "named", CHANNELS, entry='segments = [{name = "dwell", stop = 50}]')
    assert [(s.name, s.stop) for s in imported.recording.segments] == [("dwell", 50)]


def test_pieces_too_short_for_a_revolution_are_told(tmp_path: Path) -> None:
    time = np.arange(6000) / RATE
    builders.csv(tmp_path / "a.csv", t=time, q=1.0 * time, M=np.ones(time.size))
    done = builders.run(tmp_path, CHANNELS, top="pieces = {seconds = 5}")
    assert "pieces of 5 s hold 0.8 revolutions of the output at a steady speed" in " ".join(done[0].notes)
    assert sum(s.stop - s.start for piece in done for s in piece.recording.segments) == 6000


def test_a_fast_shaft_is_not_steady_at_the_top_of_a_swing() -> None:
    time = np.arange(2000) / RATE
    # five revolutions a second at the top, near which it turns nearly twice
    assert found(5.0 * np.sin(2.0 * np.pi * 0.5 * time)) == []
