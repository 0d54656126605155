import json
from pathlib import Path
from typing import Any

import pytest
import typer
from rich.console import Console
from typer.testing import CliRunner

from bench.campaigns.taken import Status, Summary, Taken
from bench.cli.app import COMMANDS, make_app
from bench.cli.exit_codes import MEANING, ExitCode, exit_code_help, exit_code_of
from bench.cli.run import _exit_code, _print
from bench.configuration import load_bench
from bench.cycle.end import NOT_WRITTEN, End, EndKind
from bench.errors import BenchError, ConfigurationError, DeviceError, LimitError, RecordingError
from bench.safety import Cause
from tests.program import bench


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


WRONG = {
    "run quick --out file": "file is a file; recordings go into a folder",
    "run quick --bench .": "bench file . cannot be read: Is a directory",
    "run .": "campaign file . cannot be read: Is a directory",
    "inspect nowhere.h5": "there is no such file",
    "validate nowhere": "there is no such file or folder",
    "acknowledge nowhere": "nowhere: there is no such folder; give that of the run that was stopped",
    "reset nowhere": "nowhere: there is no such folder; give that of the run that was stopped",
    "prove --quick --make-only --out file": "file",
}


@pytest.mark.parametrize("line", WRONG)
def test_a_mistyped_path_is_one_sentence(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BENCH_RUNTIME", str(tmp_path / "locks"))
    (tmp_path / "file").touch()
    done = bench(line.split())
    assert done.code == 3, done.err
    rows = [row for row in done.err.splitlines() if row]
    assert len(rows) == 1, done.err
    assert rows[0].startswith("error: ")
    assert WRONG[line] in rows[0]


def test_repair_names_what_is_not_there(app: typer.Typer, tmp_path: Path) -> None:
    result = call(app, "repair", str(tmp_path / "nowhere"))
    assert result.exit_code == 6
    assert result.output == f"{tmp_path / 'nowhere'}: there is no such file or folder.\n"


@pytest.mark.parametrize(
    ("end", "said"),
    [
        (
            End(EndKind.INTERRUPTED, "stopped on the operator's request"),
            "with --out first continues from here",
        ),
        (End(EndKind.TRIPPED, "too fast"), "bench acknowledge first, bench reset first"),
        (End(EndKind.FINISHED), "bench identify first --out model.json"),
    ],
)
def test_a_run_says_what_to_do_next(end: End, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    stopped = Taken("0001-x", "0001-x.h5", "x", "x", {}, "1", 1, Status.FAILED, end.text)
    summary = Summary(end=end, taken=[stopped], earlier=1, bench_time_s=10.0, cycles=20000, tare_drift=-0.001)
    _print(summary, Path("first"), None, 2.0, Console(width=80))
    output = capsys.readouterr().out
    assert said in output
    assert "1 recording, 20,000 cycles, 10 s of bench time in 2 s (5 times real time)" in output
    assert "not repeated: 1 point." in output
    assert "drifted by 0.00 N·m" in output
    # why it ended is said once
    assert output.count(end.text or "identify") == 1


@pytest.mark.parametrize(
    ("cause", "headline", "code"),
    [
        (Cause.RECORDER, "the recording cannot be written: [Errno 28] No space left on device", 7),
        (Cause.BUS_ENDED, "a device or the bus failed: ", 5),
        (Cause.MOTOR_SPEED, "a limit stopped the bench: ", 4),
        (Cause.PROGRAM, "the run's own program failed: ", 1),
    ],
)
def test_a_stop_is_told_by_its_cause(
    cause: Cause, headline: str, code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    prefix = f"{NOT_WRITTEN}: " if cause is Cause.RECORDER else ""
    summary = Summary(end=End(EndKind.TRIPPED, f"{prefix}[Errno 28] No space left on device", cause))
    _print(summary, Path("first"), None, 2.0, Console(width=200))
    output = capsys.readouterr().out
    assert headline in output
    assert output.count("cannot be written") == int(cause is Cause.RECORDER)
    assert _exit_code(summary) == code


def test_only_a_record_of_the_stop_that_is_there_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    for record, said in ((None, False), ("stop-0003.json", True)):
        summary = Summary(end=End(EndKind.TRIPPED, "too fast", Cause.MOTOR_SPEED), stop_record=record)
        _print(summary, Path("first"), None, 2.0, Console(width=200))
        output = capsys.readouterr().out
        assert ("The record of the stop" in output) == said
        assert ("first/stop-0003.json" in output) == said


def test_run_refuses_before_anything_is_opened(app: typer.Typer, tmp_path: Path) -> None:
    result = call(app, "run", "paper", "--bench", "rv80n", "--out", str(tmp_path / "out"))
    assert isinstance(result.exception, LimitError)
    assert not (tmp_path / "out").exists()
