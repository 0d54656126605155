"""Logs quicker than their drives: rows that repeat values are no samples, and slow quantities are no such rows."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.importing import Imported
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


def test_rows_beyond_the_file_are_refused_in_the_numbers_of_the_file(tmp_path: Path) -> None:
    _log(tmp_path)
    why = builders.why(tmp_path, _CHANNELS, entry="stop = 99999")
    assert f"cut rows 0 to 99999 out of rows 0 to {EVERY * COUNT}" in why
    why = builders.why(tmp_path, _CHANNELS, entry="start = 1600\nstop = 1604")
    assert f"cut rows 1600 to 1604 out of rows 0 to {EVERY * COUNT}" in why
    short = '[[recordings.segments]]\nname = "steady"\nstart = 801\nstop = 807'
    with pytest.raises(
        ConfigurationError, match=f"from row 801 to 807, it should lie within rows 0 to {EVERY * COUNT}"
    ):
        builders.run(tmp_path, _CHANNELS, entry=short)
    why = builders.why(tmp_path, _CHANNELS, entry="start_s = 900.0")
    assert f"cut rows {EVERY * COUNT} to {EVERY * COUNT} out of rows 0 to {EVERY * COUNT}" in why


def test_rows_of_a_drive_that_is_late_now_and_then_are_those_of_the_file(tmp_path: Path) -> None:
    """400 values of 8 rows, then 200 of 9: the thinned clock is uneven, and is resampled."""
    lengths = np.repeat([8, 9], [400, 200])
    number = np.repeat(np.arange(lengths.size), lengths)
    torque = np.random.default_rng(6).normal(size=lengths.size)[number]
    angle = 0.002 * (np.cumsum(lengths) - lengths)[number]
    t = np.arange(number.size) / 1000.0
    builders.csv(tmp_path / "a.csv", t=t, M=torque, q=angle, T=20.0 + 0 * t)
    recording = builders.one(tmp_path, _CHANNELS, entry="start = 3200\nstop = 4100").recording
    at = recording.si("motor_angle")
    assert at[0] == pytest.approx(angle[3200], abs=0.02)
    assert at[-1] == pytest.approx(angle[4099], abs=0.03)
    (tmp_path / "out/a.h5").unlink()
    pieces = builders.run(tmp_path, _CHANNELS, top="pieces = {seconds = 2.0, at_least = 1}")
    rows = []
    for done in pieces:
        assert isinstance(done, Imported)
        with h5py.File(done.recording.path) as file:
            rows.append((int(file.attrs["first_row"]), int(file.attrs["rows_end"])))
    assert rows[0][0] == 0
    assert rows[-1][1] == number.size
    assert all(a[1] == b[0] for a, b in itertools.pairwise(rows))


def test_an_angle_that_starts_again_is_not_interpolated(tmp_path: Path) -> None:
    _log(tmp_path)
    row = np.arange(EVERY * COUNT)
    torque = np.random.default_rng(7).normal(size=COUNT)[row // EVERY]
    angle = np.mod(0.05 * ((row + EVERY - 3) // EVERY * EVERY), 2.0 * np.pi)
    builders.csv(tmp_path / "a.csv", t=row / 1000.0, M=torque, q=angle, T=20.0 + 0 * row)
    recording = builders.one(tmp_path, _CHANNELS).recording
    assert recording.size == COUNT
    assert set(np.round(recording.si("motor_angle"), 6)) <= set(np.round(angle, 6))


def test_a_torque_that_comes_at_other_rows_is_taken_between_its_own_values(tmp_path: Path) -> None:
    """A sensor that is asked half a cycle after the drive, while the load swings."""
    row = np.arange(EVERY * COUNT)
    torque = np.random.default_rng(7).normal(size=COUNT)[row // EVERY]
    asked = np.maximum((row + EVERY // 2) // EVERY * EVERY - EVERY // 2, 0)
    load = np.round(100.0 * np.sin(0.03 * asked), 6)
    builders.csv(tmp_path / "a.csv", t=row / 1000.0, M=torque, q=0.001 * (row // EVERY), T=20.0 + 0 * row, L=load)
    channels = _CHANNELS + 'load_torque = {variable = "L", unit = "N*m"}\n'
    recording = builders.one(tmp_path, channels).recording
    assert recording.size == COUNT
    swings = 100.0 * np.sin(30.0 * recording.si("time"))
    np.testing.assert_allclose(recording.si("load_torque")[2:-2], swings[2:-2], atol=1.0)


def test_where_a_channel_has_new_values_in_every_row_all_rows_stay(tmp_path: Path) -> None:
    _log(tmp_path)
    row = np.arange(EVERY * COUNT)
    torque = np.random.default_rng(7).normal(size=COUNT)[row // EVERY]
    quick = np.sin(0.7 * row)
    builders.csv(tmp_path / "a.csv", t=row / 1000.0, M=torque, q=0.001 * (row // EVERY), T=20.0 + 0 * row, a=quick)
    channels = _CHANNELS + 'load_motor_torque = {variable = "a", unit = "N*m"}\n'
    assert builders.one(tmp_path, channels).recording.size == row.size
    (tmp_path / "out/a.h5").unlink()
    recording = builders.one(tmp_path, _CHANNELS, aux='acc = {variable = "a", unit = "m/s**2"}').recording
    assert recording.size == row.size


def test_a_rate_asked_for_that_is_not_the_log_s_is_taken(tmp_path: Path) -> None:
    _log(tmp_path)
    recording = builders.one(tmp_path, _CHANNELS, top="sample_rate = 100.0").recording
    assert recording.sample_rate == pytest.approx(100.0)


def test_gaps_are_those_of_the_log(tmp_path: Path) -> None:
    """With a gap the rows stay as they are; it is refused, or cut, as in any file."""
    row = np.arange(EVERY * COUNT)
    torque = np.random.default_rng(7).normal(size=COUNT)[row // EVERY]
    t = (row + 50.0 * (row > 1000)) / 1000.0
    builders.csv(tmp_path / "a.csv", t=t, M=torque, q=0.001 * (row // EVERY), T=20.0 + 0 * row)
    assert "gaps = 'cut'" in builders.why(tmp_path, _CHANNELS)
    first, second = builders.run(tmp_path, _CHANNELS, top='gaps = "cut"')
    assert (first.recording.size, second.recording.size) == (1001, row.size - 1001)  # type: ignore[union-attr]


def test_a_smooth_torque_without_noise_is_no_log_of_repeated_rows(tmp_path: Path) -> None:
    row = np.arange(20000)
    torque = np.round(100.0 * np.sin(2.0 * np.pi * 0.5 * row / 1000.0))
    builders.csv(tmp_path / "a.csv", t=row / 1000.0, M=torque, q=0.0 * row, T=20.0 + 0 * row)
    assert builders.one(tmp_path, _CHANNELS).recording.size == row.size


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
