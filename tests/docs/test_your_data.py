"""The page for other people's data: its example is made by its script, and says what the page quotes."""

from __future__ import annotations

import runpy
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from tests.docs.commands import ROOT, commands

RIG = ROOT / "docs/examples/rig.csv"


def test_the_example_is_what_its_script_makes(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(ROOT / "docs/examples/rig.py"))["main"]()
    assert capsys.readouterr().out == RIG.read_text("utf-8")


def test_five_commands_go_from_a_file_to_a_report() -> None:
    lines = [command.line for command in commands() if command.page == "docs/your-data.md"]
    # the first stands for the FMU that a reader brings along
    assert lines[0].startswith("bench export-model")
    five = lines[1:6]
    assert [line.split()[1] for line in five] == ["import", "import", "import", "mismatch", "predict"]
    assert "--look" in five[0]
    assert ".fmu" in five[2]
    assert "--simulation" in five[3]


def test_the_page_quotes_what_is_printed(tmp_path: Path) -> None:
    page = (ROOT / "docs/your-data.md").read_text("utf-8")
    mapping = tmp_path / "rig.toml"
    printed = CliRunner().invoke(make_app(), ["import", "--look", str(RIG), "--mapping", str(mapping)]).stdout
    for line in printed.splitlines()[1:6]:
        assert line in page
    content = tomllib.loads(mapping.read_text("utf-8"))
    assert content["gearbox"]["ratio"] == 50.0
    assert content["channels"]["motor_angle"]["wraps_at"] == 360.0
    arguments = ["import", str(mapping), "--out", str(tmp_path / "rig")]
    arguments += ["--set", "channels.motor_torque.torque_constant=-0.21"]
    printed = CliRunner().invoke(make_app(), arguments).stdout
    (warning,) = [line.strip() for line in printed.splitlines() if "WARNING" in line]
    quoted = page.split("WARNING: rig.toml: ")[1].split("\n```")[0].replace("\n", " ")
    assert warning.removeprefix(f"WARNING: {mapping}: ") == quoted
