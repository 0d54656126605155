"""The log: what was expected beside what came, kept over a stop, refused where it is something else."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bench.errors import ConfigurationError
from bench.investigate.design import Experiment
from bench.investigate.log import Came, Log, Step
from bench.mismatch.report.candidates import Candidate


def _question() -> Any:
    finding = SimpleNamespace(channel="motor_torque", effect="friction.stribeck")
    alternatives = ("friction.viscous_quadratic",)
    key = ("motor_torque", "friction.stribeck", "friction.viscous_quadratic")
    return SimpleNamespace(finding=finding, alternatives=alternatives, why="ambiguous", key=key)


def _step(gain: float | None, hours: float | None = 0.25, came: float | None = 12.0) -> Step:
    points = (Candidate("reversal", 0.0, 0.05, None, (("amplitude", '"2 deg"'), ("cycles", "3"))),)
    experiment = Experiment(points, 0.2, ((_question(), gain),), "a rule", "as found")
    results = () if hours is None else (Came(came, "friction.stribeck named"),)
    return Step(1, experiment, "experiment-1.toml", hours, results)


def test_expected_and_what_came_stand_side_by_side_and_hours_add_up(tmp_path: Path) -> None:
    log = Log.begun(tmp_path / "mine", 0.7, 8.0, tmp_path)
    log.add(_step(25.0))
    log.add(_step(None, 0.5, None))
    log.end("all is named", ["more torque: expected gain 9"])
    assert log.hours == pytest.approx(0.75)
    text = (tmp_path / "investigation.md").read_text("utf-8")
    assert (
        "| friction.stribeck or friction.viscous_quadratic | ambiguous | 25.0 | 12.0 | friction.stribeck named |"
        in text
    )
    assert "| not computed | not computed |" in text
    assert "Ended: all is named. 0.75 h" in text
    assert "- reversal, 0 N·m, 0.05 rad/s, amplitude 2 deg, cycles 3" in text
    assert "more torque" in text


def test_what_was_run_before_a_stop_stays_and_is_not_asked_by_the_same_rule_again(tmp_path: Path) -> None:
    log = Log.begun(tmp_path / "mine", 0.7, 8.0, tmp_path)
    log.add(_step(None))
    log.add(_step(None, None))  # designed and never run
    again = Log.begun(tmp_path / "mine", 0.7, 8.0, tmp_path)
    assert len(again.earlier) == 1
    assert again.hours == pytest.approx(0.25)
    assert again.done == {(*_question().key, "a rule")}


@pytest.mark.parametrize("content", ["{", json.dumps({"format": "bench-other", "steps": []}), "[]"])
def test_another_file_of_that_name_is_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / "investigation.json").write_text(content, "utf-8")
    with pytest.raises(ConfigurationError, match="--out"):
        Log.begun(tmp_path / "mine", 0.7, 8.0, tmp_path)
