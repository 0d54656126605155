"""Cutting: every sample in exactly one piece, of the length asked for, and enough pieces where that is possible."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.errors import ConfigurationError
from bench.importing import Imported
from bench.importing.cutting import LEAST_SAMPLES, cut, travelled
from tests.bench.importing import builders


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.floats(0.0, 2.0), min_size=2, max_size=400),
    st.floats(0.1, 500.0),
    st.integers(1, 8),
    st.sampled_from([(0.0, "s"), (2.0, "revolutions")]),
)
def test_every_sample_is_in_exactly_one_piece(
    steps: list[float], length: float, at_least: int, kind: tuple[float, str]
) -> None:
    progress = np.cumsum(steps) - steps[0]
    made = cut(progress, length, at_least, *kind)
    rows = np.concatenate([np.arange(progress.size)[piece] for piece in made.pieces])
    np.testing.assert_array_equal(rows, np.arange(progress.size))
    if len(made.pieces) > 1:
        assert min(piece.stop - piece.start for piece in made.pieces) >= LEAST_SAMPLES
    if len(made.pieces) < at_least:
        assert made.note


@settings(max_examples=100, deadline=None)
@given(st.floats(12.0, 200.0), st.integers(2, 30))
def test_pieces_are_as_long_as_asked_and_six_where_two_revolutions_each_allow_it(total: float, length: int) -> None:
    progress = np.linspace(0.0, total, 20_000)
    # a bound lies on a sample: begin and last sample of a piece are each up to one away, and the sums are rounded
    tolerance = 2 * total / 19_999 * (1 + 1e-9)
    made = cut(progress, float(length), 6, 2.0, "revolutions")
    assert len(made.pieces) >= 6 or total < 12.0
    run = [progress[piece.stop - 1] - progress[piece.start] for piece in made.pieces]
    if total >= 5.9 * length:
        assert run[:-1] == pytest.approx([length] * (len(run) - 1), abs=tolerance)
        assert not made.note
    else:
        assert min(run[:-1]) >= 2.0 - tolerance
        assert "and not of" in made.note


def test_noise_of_an_encoder_adds_up_to_no_revolution() -> None:
    time = np.arange(20_000) / 1000
    noise = np.random.default_rng(1).normal(0, 1e-3, time.size)
    assert travelled(noise, time)[-1] < 1.0
    there_and_back = 10 * np.sin(2 * np.pi * time / 20)
    assert travelled(there_and_back, time)[-1] == pytest.approx(40.0, rel=1e-3)


def _write(tmp_path: Path) -> None:
    time = np.round(np.arange(2000) * 0.01, 6)
    builders.csv(tmp_path / "a.csv", t=time, q=4 * np.pi * time, M=np.sin(time))


_CHANNELS = 'motor_angle = {variable = "q", unit = "rad"}\nmotor_torque = {variable = "M", unit = "N*m"}'


def test_a_long_recording_becomes_pieces_that_continue_each_other(tmp_path: Path) -> None:
    _write(tmp_path)  # 40 revolutions of the motor, 8 of the output
    done = builders.run(tmp_path, _CHANNELS, ratio="5.0", top="pieces = {revolutions = 4, at_least = 2}")
    found = [item.recording for item in done if isinstance(item, Imported)]
    assert [recording.recording_id for recording in found] == ["a-01", "a-02"]
    assert sum(recording.size for recording in found) == 2000
    assert found[1].si("time", 0, 1).tolist() == [0.0]
    assert (found[1].started_at - found[0].started_at).total_seconds() == pytest.approx(10.0, abs=0.02)
    np.testing.assert_allclose(
        np.concatenate([recording.si("motor_torque") for recording in found]),
        np.sin(np.arange(2000) * 0.01),
        atol=1e-12,
    )


def test_start_and_stop_cut_a_recording_out(tmp_path: Path) -> None:
    _write(tmp_path)
    entry = 'recording_id = "first"\nstart_s = 2.0\nstop_s = 5.0\n[[recordings]]\nfile = "a.csv"\n'
    entry += 'recording_id = "second"\nstart = 500'
    done = builders.run(tmp_path, _CHANNELS, entry=entry)
    found = [item.recording for item in done if isinstance(item, Imported)]
    assert [(recording.recording_id, recording.size) for recording in found] == [("first", 300), ("second", 1500)]
    assert found[0].si("motor_torque", 0, 1)[0] == pytest.approx(np.sin(2.0))


def test_pieces_are_counted_over_all_files(tmp_path: Path) -> None:
    _write(tmp_path)
    files = 'recording_id = "r0"\n' + "".join(
        f'[[recordings]]\nfile = "a.csv"\nrecording_id = "r{k}"\n' for k in (1, 2)
    )
    done = builders.run(tmp_path, _CHANNELS, ratio="5.0", entry=files, top="pieces = {seconds = 10}")
    made = [item.recording for item in done if isinstance(item, Imported)]
    assert [round(recording.size / 100) for recording in made] == [10] * 6
    assert not any("at_least" in note for item in done if isinstance(item, Imported) for note in item.notes)
    (tmp_path / "two").mkdir()
    _write(tmp_path / "two")
    files = 'recording_id = "r0"\n[[recordings]]\nfile = "a.csv"\nrecording_id = "r1"\n'
    done = builders.run(tmp_path / "two", _CHANNELS, ratio="5.0", entry=files, top="pieces = {seconds = 15}")
    assert len(done) == 6
    assert isinstance(done[0], Imported)
    assert "because pieces.at_least wants 3 pieces of these 19.99 s" in " ".join(done[0].notes)


def test_what_cannot_be_cut_so_is_said(tmp_path: Path) -> None:
    _write(tmp_path)
    done = builders.run(tmp_path, _CHANNELS, ratio="50.0", top="pieces = {revolutions = 1}")
    assert isinstance(done[0], Imported)
    assert "fewer than the 6 asked for" in " ".join(done[0].notes)
    assert "cut rows 1999 to 2000 out of" in builders.why(tmp_path, _CHANNELS, entry="start = 1999")
    channels = 'motor_angle = {variable = "q", unit = "mm"}'
    with pytest.raises(ConfigurationError, match=r"pieces.revolutions: a linear axis has none, pieces.seconds"):
        builders.run(tmp_path, channels, top="pieces = {revolutions = 1}", file="a.csv")
    with pytest.raises(ConfigurationError, match="should have either 'revolutions' or 'seconds'"):
        builders.run(tmp_path, _CHANNELS, top="pieces = {}")
