import json
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from bench.cli.app import COMMANDS, make_app
from bench.cli.exit_codes import MEANING, ExitCode, exit_code_help, exit_code_of
from bench.configuration import load_bench
from bench.errors import BenchError, ConfigurationError, DeviceError, LimitError, RecordingError


@pytest.fixture(scope="module")
def app() -> typer.Typer:
    return make_app()


def call(app: typer.Typer, *arguments: str) -> Any:
    return CliRunner().invoke(app, list(arguments))


def test_help_lists_the_commands_and_the_exit_codes(app: typer.Typer) -> None:
    text = call(app, "--help").output
    for name in ("run", "plan", "config", "benchmark"):
        assert name in text
        assert name in COMMANDS
    assert "Exit codes" in text


@pytest.mark.parametrize("command", ["run", "plan", "config"])
def test_every_command_has_a_help_one_can_learn_from(app: typer.Typer, command: str) -> None:
    result = call(app, command, "--help")
    assert result.exit_code == 0
    assert "--json" in result.output


def test_exit_codes_are_documented() -> None:
    assert set(MEANING) == set(ExitCode)
    for code in ExitCode:
        assert str(code.value) in exit_code_help()
    assert [exit_code_of(error("x")) for error in (ConfigurationError, RecordingError, LimitError, DeviceError)] == [
        3,
        3,
        4,
        5,
    ]
    assert exit_code_of(BenchError("x")) is ExitCode.BAD_INPUT


def test_plan_as_json_holds_every_point(app: typer.Typer) -> None:
    plan = json.loads(call(app, "plan", "paper", "--json").output)
    assert plan["points"] == 243
    assert sum(not task["preparation"] for task in plan["tasks"]) == 243
    assert plan["duration_s"] == pytest.approx(sum(task["duration_s"] for task in plan["tasks"]))
    assert plan["heating_s"] > 3600
    assert plan["energy_j"] > 0


def test_plan_shows_heat_up_times_and_sums(app: typer.Typer) -> None:
    output = call(app, "plan", "distinguish").output
    assert "heating" in output
    assert "no limit is broken" in output.replace("\n", " ")


def test_a_warmer_start_needs_less_heating(app: typer.Typer) -> None:
    cold, warm = (
        json.loads(call(app, "plan", "paper", "--json", "--start-temperature", t).output)["heating_s"]
        for t in ("21", "28")
    )
    assert warm < cold


def test_config_shows_lists_and_prints(app: typer.Typer, tmp_path: Path) -> None:
    assert "gearbox.ratio" in call(app, "config").output
    assert set(json.loads(call(app, "config", "--list", "--json").output)) == {"rh380n", "rh380n-wire", "rv80n"}
    assert json.loads(call(app, "config", "rv80n", "--json").output)["gearbox"]["ratio"] == 81.0
    text = call(app, "config", "rh380n", "--toml").output
    assert text == load_bench("rh380n").text
    path = tmp_path / "mine.toml"
    path.write_text(text.replace("ratio = 185.0", "ratio = -1.0"), "utf-8")
    result = call(app, "config", str(path))
    assert isinstance(result.exception, ConfigurationError)
    assert "gearbox.ratio" in str(result.exception)


def test_run_refuses_before_anything_is_opened(app: typer.Typer, tmp_path: Path) -> None:
    result = call(app, "run", "paper", "--bench", "rv80n", "--out", str(tmp_path / "out"))
    assert isinstance(result.exception, LimitError)
    assert not (tmp_path / "out").exists()
