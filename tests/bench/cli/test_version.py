"""What stands before any command, and a package that is not there."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

import bench
from bench.cli import app


def test_the_version_is_said() -> None:
    answer = CliRunner().invoke(app.make_app(), ["--version"])
    assert answer.exit_code == 0
    assert answer.output.strip() == f"gearbench {bench.__version__}"


def test_without_anything_there_is_help() -> None:
    assert "Usage" in CliRunner().invoke(app.make_app(), []).output


def test_a_package_that_is_missing_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def missing() -> None:
        raise ModuleNotFoundError("No module named 'nptdms'", name="nptdms.tdms")

    monkeypatch.setattr(app, "make_app", lambda: missing)
    with pytest.raises(SystemExit) as ended:
        app.main()
    assert ended.value.code == 3
    said = capsys.readouterr().err
    assert "pip install 'gearbench[tdms]'" in said
    assert "Traceback" not in said


def test_what_is_missing_and_no_extra_is_a_fault_of_this_program(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> None:
        raise ModuleNotFoundError("No module named 'numpi'", name="numpi")

    monkeypatch.setattr(app, "make_app", lambda: missing)
    with pytest.raises(ModuleNotFoundError):
        app.main()


def test_every_extra_that_is_named_is_there() -> None:
    project = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text("utf-8"))["project"]
    assert set(app._EXTRAS.values()) <= set(project["optional-dependencies"])
