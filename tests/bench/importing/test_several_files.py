"""Recordings of several files each, and several recordings: which file is whose, and what is said of all once."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.errors import ConfigurationError
from bench.importing import Imported
from bench.importing.looking import draft, take_inventory
from tests.bench.importing import builders

_T = np.arange(2000) / 200
_Q = 50 * np.sin(_T) + 10 * _T


def _files(folder: Path, runs: int = 1, late: float = 0.0, samples: int = _T.size) -> None:
    """A file with the time for each of three channels, of several runs; the current's clock begins later."""
    for run in range(runs):
        builders.csv(folder / f"sweep{run}_cur.csv", t=_T[:samples] + late, current=np.cos(_T[:samples]))
        builders.csv(folder / f"sweep{run}_pos.csv", t=_T, pos=_Q)
        builders.csv(folder / f"sweep{run}_vel.csv", t=_T, vel=np.gradient(_Q, _T))


def _content(folder: Path, pattern: str) -> dict[str, Any]:
    return tomllib.loads(draft(take_inventory(folder / pattern), folder / "map.toml").text())


def test_a_file_with_the_time_for_each_channel_is_one_recording(tmp_path: Path) -> None:
    _files(tmp_path, runs=2)
    content = _content(tmp_path, "sweep0_*.csv")
    assert content["channels"]["motor_angle"] == {"variable": "pos", "file": "sweep0_pos.csv", "unit": "?"}
    assert content["channels"]["motor_torque"] == {"variable": "current", "unit": "A", "torque_constant": "?"}
    assert content["recordings"] == [{"file": "sweep0_cur.csv"}]
    assert content["channels"]["time"] == {"variable": "t", "unit": "s"}


@pytest.mark.parametrize(("late", "samples"), [(0.001, _T.size), (0.0, 1500)])
def test_a_clock_that_is_not_the_first_files_is_kept(tmp_path: Path, late: float, samples: int) -> None:
    _files(tmp_path, late=late, samples=samples)
    channels = _content(tmp_path, "sweep0_*.csv")["channels"]
    assert channels["motor_angle"]["time"] == channels["motor_velocity"]["time"] == "t"
    assert "time" not in channels["motor_torque"]


def test_files_of_several_recordings_with_other_columns_are_said_to_be(tmp_path: Path) -> None:
    _files(tmp_path, runs=2)
    made = draft(take_inventory(tmp_path / "*.csv"), tmp_path / "map.toml")
    (remark,) = made.remarks
    assert remark.startswith("sweep0_pos.csv has other columns than sweep0_cur.csv")
    (shown, *_) = _look(tmp_path, "*.csv").splitlines()
    assert shown.endswith("sweep0_cur.csv is the first of 6 files that fit; the others are not shown")
    assert draft(take_inventory(tmp_path / "*_pos.csv"), tmp_path / "map.toml").remarks == []


def test_runs_of_which_one_has_a_column_more_are_runs(tmp_path: Path) -> None:
    builders.csv(tmp_path / "run0.csv", t=_T, pos=_Q)
    builders.csv(tmp_path / "run1.csv", t=_T, pos=_Q, temp=_T)
    assert [column.name for column in take_inventory(tmp_path / "run*.csv").columns] == ["t", "pos"]


def _look(folder: Path, pattern: str) -> str:
    arguments = ["import", "--look", str(folder / pattern), "--mapping", str(folder / "look.toml")]
    return CliRunner().invoke(make_app(), arguments, catch_exceptions=False).output


_CHANNELS = """
motor_angle = {{variable = "pos", unit = "rad"}}
motor_torque = {{variable = "current", file = "{file}", unit = "A", torque_constant = 0.1}}
"""


def test_one_file_of_a_channel_is_not_read_for_several_recordings(tmp_path: Path) -> None:
    _files(tmp_path, runs=2)
    with pytest.raises(ConfigurationError) as error:
        builders.run(tmp_path, _CHANNELS.format(file="sweep0_cur.csv"), file="sweep*_pos.csv")
    said = "channels.motor_torque.file: 'sweep0_cur.csv' would be read for 2 recordings, each should have its own"
    assert said in str(error.value)
    assert "such as 'sweep*_cur.csv'" in str(error.value)
    done = builders.run(tmp_path, _CHANNELS.format(file="sweep*_cur.csv"), file="sweep*_pos.csv")
    assert len(done) == 2


def test_one_file_may_be_read_for_several_parts_of_a_recording_or_with_a_clock_of_its_own(tmp_path: Path) -> None:
    _files(tmp_path, runs=2)
    parts = 'recording_id = "a"\nstop_s = 4\n[[recordings]]\nfile = "sweep0_pos.csv"\nstart_s = 5\nrecording_id = "b"'
    channels = _CHANNELS.format(file="sweep0_cur.csv")
    assert len(builders.run(tmp_path, channels, file="sweep0_pos.csv", entry=parts)) == 2
    shutil.rmtree(tmp_path / "out")
    own = channels.replace('unit = "A"', 'unit = "A", time = "t"')
    assert len(builders.run(tmp_path, own, file="sweep*_pos.csv")) == 2


@pytest.mark.parametrize(
    ("channels", "ratio", "said"),
    [
        ('motor_angle = {variable = "pos", unit = "deg", wraps_at = 360}', "81", "up to multiples of 4.444° only"),
        ('motor_angle = {variable = "pos", unit = "deg"}', "81", None),
        ('motor_angle = {variable = "pos", unit = "deg", wraps_at = 360}', "1", None),
    ],
)
def test_an_angle_that_starts_again_loses_the_outputs_position_from_file_to_file(
    tmp_path: Path, channels: str, ratio: str, said: str | None
) -> None:
    for run in range(2):
        builders.csv(tmp_path / f"run{run}.csv", t=_T, pos=_Q % 360)
    done = builders.run(tmp_path, channels, ratio=ratio, file="run*.csv")
    notes = [note for one in done if isinstance(one, Imported) for note in one.notes if "counted anew" in note]
    assert len(notes) == (2 if said else 0)
    assert said is None or said in notes[0]
    shutil.rmtree(tmp_path / "out")
    parts = 'recording_id = "a"\nstop_s = 4\n[[recordings]]\nfile = "run0.csv"\nstart_s = 5\nrecording_id = "b"'
    of_one = builders.run(tmp_path, channels, ratio=ratio, file="run0.csv", entry=parts)
    assert not any("counted anew" in note for one in of_one if isinstance(one, Imported) for note in one.notes)


def test_what_was_done_to_all_files_is_said_once_and_after_the_warnings(tmp_path: Path) -> None:
    _files(tmp_path, runs=3)
    builders.run(tmp_path, _CHANNELS.format(file="sweep*_cur.csv"), file="sweep*_pos.csv", ratio="50")
    shutil.rmtree(tmp_path / "out")
    done = CliRunner().invoke(make_app(), ["import", str(tmp_path / "map.toml"), "--out", str(tmp_path / "out")])
    assert done.output.count("started_at is the modification time") == 1
    assert "in 3 of 3 files started_at is the modification time" in done.output
    assert done.output.index("sweep2_pos.h5") < done.output.index("started_at is")


def test_many_files_with_the_same_channels_are_told_in_a_few_lines(tmp_path: Path) -> None:
    for run in range(8):
        factor = -1.0 if run == 6 else 1.0
        builders.csv(tmp_path / f"run{run}.csv", t=_T, pos=_Q, vel=factor * np.gradient(_Q, _T))
    channels = 'motor_angle = {variable = "pos", unit = "deg"}\nmotor_velocity = {variable = "vel", unit = "deg/s"}'
    done = builders.run(tmp_path, channels, file="run*.csv")
    assert [bool(one.warnings) for one in done if isinstance(one, Imported)] == [run == 6 for run in range(8)]
    shutil.rmtree(tmp_path / "out")
    shown = CliRunner().invoke(make_app(), ["import", str(tmp_path / "map.toml"), "--out", str(tmp_path / "out")])
    lines = shown.output.splitlines()
    assert sum(" rows (" in one for one in lines) == 6
    assert (
        f"and 3 more files: {tmp_path / 'out' / 'run5'}.h5 to run7.h5: 3 recordings, 6000 rows (30.0 s) of time,"
        " motor_angle, motor_velocity" in lines
    )
    assert sum(one.startswith("  WARNING: run6: ") for one in lines) == 1
    assert len(list((tmp_path / "out").glob("*.h5"))) == 8


def test_notes_of_many_files_that_differ_in_numbers_alone_are_one_line(tmp_path: Path) -> None:
    channels = 'motor_angle = {variable = "pos", unit = "deg"}'
    for runs, lines in ((6, ["in 6 of 6 files by the time stamps 1 … 6 of 2000 samples are missing"]), (3, None)):
        folder = tmp_path / str(runs)
        folder.mkdir()
        for run in range(runs):
            there = np.delete(np.arange(_T.size), 100 + 7 * np.arange(run + 1))
            builders.csv(folder / f"run{run}.csv", t=_T[there], pos=_Q[there])
        done = builders.run(folder, channels, file="run*.csv")
        assert all("samples are missing" in " ".join(one.notes) for one in done if isinstance(one, Imported))
        shutil.rmtree(folder / "out")
        shown = CliRunner().invoke(make_app(), ["import", str(folder / "map.toml"), "--out", str(folder / "out")])
        said = [line for line in shown.output.splitlines() if "samples are missing" in line]
        each = [f"run{run}: by the time stamps {run + 1} of 2000 samples are missing" for run in range(runs)]
        assert said == (lines or each)


def test_columns_are_aligned_under_long_headings_and_units(tmp_path: Path) -> None:
    long = "Actual velocity of the motor's shaft before the brake (rad/s)"
    builders.csv(tmp_path / "a.csv", **{"Time (s)": _T, long: _Q, "inertia [kg*m**2]": _T, "short": _Q})
    rows = [row for row in _look(tmp_path, "a.csv").splitlines() if "…" in row and "columns of" not in row][:4]
    places = {row.rindex(" … ") for row in rows}
    assert len(rows) == 4
    assert len(places) == 1
    assert "Actual velocity of" in rows[1]


def test_a_file_that_is_not_there_is_named_with_the_folder_its_name_counts_from(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    _files(tmp_path / "data")
    channels = _CHANNELS.format(file="data/sweep0_cur.csv")
    why = builders.why(tmp_path, channels, file="data/sweep0_pos.csv")
    assert "'data/sweep0_cur.csv', the 'file' of a channel, counts from the folder of the recording's own file" in why
    assert why.endswith(f"sweep0_pos.csv: {tmp_path / 'data'}; did you mean 'sweep0_cur.csv'?")
    why = builders.why(tmp_path, channels, file="sweep0_pos.csv")
    assert why.endswith(f"counts from the folder of the mapping, or that of --data: here {tmp_path}.")
    with pytest.raises(ConfigurationError, match=f"recordings.file, which counts from {tmp_path}"):
        builders.run(tmp_path, channels, file="sweep*_pos.csv")


_JOINTS = {f"Joint_{k}": k * np.sin(k * _T) for k in (1, 2, 3)}


def test_a_matrix_for_each_quantity_with_equal_headings_is_one_recording(tmp_path: Path) -> None:
    builders.csv(tmp_path / "pos_read_data.csv", **_JOINTS)
    builders.csv(tmp_path / "curr_data.csv", **{name: values + 0.1 * _T for name, values in _JOINTS.items()})
    shown = _look(tmp_path, "*.csv")
    assert "not shown" not in shown
    assert "6 columns of 2000" in shown
    text = (tmp_path / "look.toml").read_text()
    content = tomllib.loads(text)
    assert content["recordings"] == [{"file": "curr_data.csv"}]
    tables = [*content["channels"].values(), *content["aux"].values()]
    placed = {(table.get("file"), table["variable"]) for table in tables if "variable" in table}
    assert placed == {(file, name) for file in (None, "pos_read_data.csv") for name in _JOINTS}
    assert content["channels"]["motor_torque"]["variable"] == content["channels"]["load_angle"]["variable"] == "Joint_3"
    # runs of one quantity are no matrices of several, and stay apart
    builders.csv(tmp_path / "pos_other.csv", **_JOINTS)
    (tmp_path / "look.toml").unlink()
    assert "is the first of 2 files that fit; the others are not shown" in _look(tmp_path, "pos*.csv")


def test_matrices_called_alike_with_a_common_clock_are_one_recording(tmp_path: Path) -> None:
    rows = np.vstack([_T, *_JOINTS.values()])
    np.savez(tmp_path / "run1_joint.npz", ans=rows)
    np.savez(tmp_path / "run1_torque.npz", ans=np.vstack([_T, *(0.3 * np.cos(row) for row in _JOINTS.values())]))
    columns = take_inventory(tmp_path / "run1_*.npz").columns
    assert [column.name for column in columns if column.file] == [f"run1_torque row {k}" for k in (2, 3, 4)]
    content = _content(tmp_path, "run1_*.npz")
    assert content["channels"]["time"]["variable"] == "ans"
    assert content["channels"]["motor_torque"]["file"] == "run1_torque.npz"
    # names that differ in more than a word, or of which none is of a quantity, are runs
    np.savez(tmp_path / "torque_step.npz", ans=rows)
    assert len(take_inventory(tmp_path / "[rt]*.npz").columns) == 4
