"""What ``bench run --twin`` refuses before anything moves, and what it says at the end."""

from __future__ import annotations

from pathlib import Path

import pytest
from rich.console import Console

from bench.cli._twin import TwinMessages, say_seen, watched_by
from bench.cli.run import run
from bench.errors import ConfigurationError
from bench.service.client import Refused, _analysis
from tests.program import bench


def test_a_pause_without_a_twin_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="give one with --twin"):
        run("quick", out=tmp_path / "run", twin_pause=True)
    assert not (tmp_path / "run").exists()


def test_a_model_that_is_not_there_is_refused_before_anything_is_done(tmp_path: Path) -> None:
    reached = False
    with (
        pytest.raises(ConfigurationError, match="no such model"),
        watched_by(tmp_path / "model.json", tmp_path, None, Console()),
    ):
        reached = True
    assert not reached


def test_a_model_that_is_not_there_is_refused_before_the_plan_is_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = bench(["run", "quick", "--out", "run", "--twin", "nothere.json"])
    assert (done.code, done.out) == (3, "")
    assert "nothere.json: there is no such model" in done.err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("command", ["run", "investigate", "emulate", "compensate"])
def test_a_seed_below_zero_is_a_wrong_command_line(command: str) -> None:
    done = bench([command, "x", "--seed", "-1"])
    assert (done.code, done.out) == (2, "")
    assert "--seed" in done.err


def test_beside_a_service_the_model_is_one_of_its_analyses() -> None:
    assert _analysis(Path("recordings/.service/analyses/20260101T000000-abc/model.json")) == "20260101T000000-abc"
    with pytest.raises(Refused, match="no model of the service"):
        _analysis(Path("model.json"))


@pytest.mark.parametrize(
    ("heard", "said"),
    [
        (TwinMessages(looked={"tested": 8, "points": 24, "not_watched": {}}), "holds in all 8 recordings"),
        (
            TwinMessages(looked={"tested": 0, "points": 5, "not_watched": {}}),
            "5 recordings at one point each are too few",
        ),
        (
            TwinMessages(why="it broke", looked={"tested": 8, "points": 24, "not_watched": {"temperature": "no C"}}),
            "it broke",
        ),
        (TwinMessages(unread={"0007": "cut"}), "0007 was not looked at: cut"),
    ],
)
def test_what_the_twin_saw_is_said(heard: TwinMessages, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    say_seen(heard, Console(width=200))
    assert said in capsys.readouterr().out
