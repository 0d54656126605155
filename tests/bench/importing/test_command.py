"""What ``bench import`` says and does on the command line: once what is the same of many files, and where files are."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from typer.testing import CliRunner, Result

from bench.cli.app import make_app


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
