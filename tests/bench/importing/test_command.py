"""What ``bench import`` says and does on the command line: once what is the same of many files, and where files are."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from bench.cli.app import make_app
from bench.errors import ConfigurationError
from bench.importing import import_recordings
from tests.bench.importing import builders


def _bench(*arguments: object) -> Result:
    return CliRunner().invoke(make_app(), [str(argument) for argument in arguments])


def test_import_says_once_why_many_files_are_refused(tmp_path: Path) -> None:
    for k in range(8):
        name, heading = f"run_{k}.csv", "t,Winkel[mm]" if k < 7 else "t,Weg"
        np.savetxt(tmp_path / name, np.ones((9, 2)), delimiter=",", header=heading, comments="")
    (tmp_path / "map.toml").write_text(
        """
campaign_id = "rig"
gearbox.ratio = 1.0
channels.time.rate = 100.0
channels.motor_angle = {variable = "Winkel", unit = "mm"}
[[recordings]]
file = "run_*.csv"
""",
        encoding="utf-8",
    )
    result = _bench("import", tmp_path / "map.toml", "--out", tmp_path / "out")
    assert result.exit_code == 6
    said = result.stdout.splitlines()
    assert len(said) == 3, result.stdout
    assert said[0].endswith("there is no variable 'Winkel'; the file has t, Winkel[mm] (did you mean 'Winkel[mm]'?).")
    assert said[1].endswith("the file has t, Weg.")
    assert said[2] == (
        "run_1.csv, run_2.csv, run_3.csv, run_4.csv, run_5.csv and 1 more could not be imported for the same reason as "
        "run_0.csv"
    )
    listed = json.loads(_bench("import", tmp_path / "map.toml", "--out", tmp_path / "out", "--json").stdout)
    assert sum("error" in row for row in listed) == 8


def test_an_angle_of_the_output_alone_is_told_of_in_one_sentence(tmp_path: Path) -> None:
    time = 0.01 * np.arange(2000)
    builders.csv(tmp_path / "a.csv", t=time, q=np.sin(time), M=np.cos(time))
    angle, torque = '{variable = "q", unit = "rad"}', '{variable = "M", unit = "N*m"}'
    builders.run(tmp_path, f"load_angle = {angle}\nmotor_torque = {torque}", ratio="6.0")
    said = _bench("import", tmp_path / "map.toml", "--out", tmp_path / "again").stdout.splitlines()
    assert [sentence for sentence in said if "load_angle" in sentence] == [
        "the motor's angle was not measured: motor_angle is load_angle times gearbox.ratio 6, so load_angle is not "
        "kept beside it and there is no transmission error"
    ]
    # where none was mapped at all, that is what is missing
    (tmp_path / "b").mkdir()
    builders.csv(tmp_path / "b" / "a.csv", t=time, q=np.sin(time), M=np.cos(time))
    done = builders.one(tmp_path / "b", f"motor_angle = {angle}\nmotor_torque = {torque}", ratio="6.0")
    assert any("there is no channel 'load_angle'" in sentence for sentence in done.consequences)


def _measured(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    time = np.arange(500) / 100
    return builders.csv(path, **{"t [s]": time, "motor angle [rad]": np.sin(time), "motor torque [Nm]": np.cos(time)})


def test_the_mapping_of_a_look_finds_its_file_in_the_folder_of_data(tmp_path: Path) -> None:
    """Its file counts from the mapping, and --data may name any of the folders on the way to it."""
    file = _measured(tmp_path / "raw" / "axis" / "run.csv")
    mapping = tmp_path / "l.toml"
    assert _bench("import", "--look", file, "--mapping", mapping, "--set", "gearbox.ratio=1.0").exit_code == 0
    assert 'file = "raw/axis/run.csv"' in mapping.read_text(encoding="utf-8")
    for k, data in enumerate(([], [tmp_path], [tmp_path / "raw"], [tmp_path / "raw" / "axis"])):
        options = ["--data", *data] if data else []
        result = _bench("import", mapping, "--out", tmp_path / f"out{k}", *options)
        assert result.exit_code == 0, result.stdout
        assert (tmp_path / f"out{k}" / "run.h5").exists()
    # a pattern too; a file that is nowhere is told of by the name in the mapping
    text = mapping.read_text(encoding="utf-8")
    mapping.write_text(text.replace("axis/run.csv", "axis/r*.csv"), encoding="utf-8")
    assert _bench("import", mapping, "--out", tmp_path / "o1", "--data", tmp_path / "raw" / "axis").exit_code == 0
    mapping.write_text(text.replace("axis/run.csv", "axis/other.csv"), encoding="utf-8")
    result = _bench("import", mapping, "--out", tmp_path / "o2", "--data", tmp_path / "raw")
    assert result.exit_code == 6
    assert "raw/axis/other.csv: there is no such file" in result.stdout


def test_two_files_that_would_be_one_in_the_folder_of_data_are_refused(tmp_path: Path) -> None:
    for day in ("day1", "day2"):
        _measured(tmp_path / day / "run.csv")
    _measured(tmp_path / "here" / "run.csv")
    mapping = tmp_path / "map.toml"
    assert _bench("import", "--look", tmp_path / "day1" / "run.csv", "--mapping", mapping).exit_code == 0
    text = mapping.read_text(encoding="utf-8").replace('ratio = "?"', "ratio = 1.0")
    mapping.write_text(f'{text}[[recordings]]\nfile = "day2/run.csv"\n', encoding="utf-8")
    with pytest.raises(ConfigurationError, match=r"'day1/run\.csv' and 'day2/run\.csv' would both be"):
        list(import_recordings(mapping, tmp_path / "out", tmp_path / "here"))
