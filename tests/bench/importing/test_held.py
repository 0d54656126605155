"""Logs quicker than their drives: rows that repeat values are no samples, and slow quantities are no such rows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.bench.importing import builders

_CHANNELS = """
motor_torque = {variable = "M", unit = "N*m"}
motor_angle = {variable = "q", unit = "rad"}
temperature = {variable = "T", unit = "degC"}
"""
EVERY = 8
COUNT = 300


def _log(folder: Path, seed: int = 3) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """A log of 1 kHz whose drive answers every eighth row, angle three rows after torque; what the drive said."""
    rng = np.random.default_rng(seed)
    row = np.arange(EVERY * COUNT)
    torque = np.round(rng.normal(size=COUNT), 6)
    angle = np.round(np.sin(0.002 * (np.arange(COUNT + 1) * EVERY - 5)), 9)
    t = row / 1000.0
    builders.csv(
        folder / "a.csv", t=t, M=torque[row // EVERY], q=angle[(row + EVERY - 3) // EVERY], T=20.0 + row // 100
    )
    return torque, angle


def test_rows_that_repeat_what_the_drive_said_are_left_out(tmp_path: Path) -> None:
    torque, _ = _log(tmp_path)
    done = builders.one(tmp_path, _CHANNELS)
    recording = done.recording
    assert recording.sample_rate == pytest.approx(125.0)
    np.testing.assert_allclose(recording.si("motor_torque"), torque)
    # the angle comes three rows after the torque: at the torque's rows it is between two of its own values
    time = recording.si("time")[2:-2]
    np.testing.assert_allclose(recording.si("motor_angle")[2:-2], np.sin(2.0 * time), atol=1e-4)
    np.testing.assert_array_equal(recording.si("temperature"), 20.0 + np.arange(COUNT) * EVERY // 100)
    assert any("1000 rows a second, but new values only every 8 rows (125 Hz)" in note for note in done.notes)


def test_a_mapping_may_keep_all_rows(tmp_path: Path) -> None:
    _log(tmp_path)
    recording = builders.one(tmp_path, _CHANNELS, top='repeated = "keep"').recording
    assert recording.size == EVERY * COUNT
    assert recording.sample_rate == pytest.approx(1000.0)


def test_rows_that_the_mapping_names_are_those_of_the_file(tmp_path: Path) -> None:
    torque, _ = _log(tmp_path)
    entry = 'start = 800\nstop = 1600\n[[recordings.segments]]\nname = "steady"\nstart = 880\nstop = 1200'
    recording = builders.one(tmp_path, _CHANNELS, entry=entry).recording
    np.testing.assert_allclose(recording.si("motor_torque"), torque[100:200])
    (segment,) = recording.segments
    assert (segment.start, segment.stop) == (10, 50)


def test_the_rate_that_the_mapping_says_is_that_of_the_log(tmp_path: Path) -> None:
    torque, _ = _log(tmp_path)
    recording = builders.one(tmp_path, _CHANNELS, top="sample_rate = 1000.0").recording
    assert recording.sample_rate == pytest.approx(125.0)
    np.testing.assert_allclose(recording.si("motor_torque"), torque)


def test_a_torque_of_few_steps_and_an_encoder_that_turns_evenly_are_no_repeated_rows(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    row = np.arange(4000)
    # a coarse current: one step up or down now and then, sometimes in the next row
    torque = np.cumsum(np.where(rng.random(row.size) < 0.2, rng.choice([-1, 1], row.size), 0))
    builders.csv(tmp_path / "a.csv", t=row / 1000.0, M=torque, q=row // 8 * 0.001, T=20.0 + 0 * row)
    recording = builders.one(tmp_path, _CHANNELS).recording
    assert recording.size == 4000
    assert recording.sample_rate == pytest.approx(1000.0)


def test_where_the_machine_stands_before_it_moves_nothing_is_lost(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    row = np.arange(EVERY * COUNT)
    torque = np.where(np.arange(COUNT) < 100, 0.0, np.round(rng.normal(size=COUNT), 6))
    builders.csv(tmp_path / "a.csv", t=row / 1000.0, M=torque[row // EVERY], q=0.0 * row, T=20.0 + 0 * row)
    recording = builders.one(tmp_path, _CHANNELS).recording
    np.testing.assert_allclose(recording.si("motor_torque"), torque)
