"""What ``bench mismatch`` prints of a report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bench.cli.mismatch import _say
from bench.mismatch.report.verdict import kind_of_simulation

CHANNEL: dict[str, Any] = {
    "channel": "motor_torque",
    "unit": "N*m",
    "noise_floor": 0.02,
    "held_out_rmse_as_given": None,
    "held_out_rmse_before": 0.06,
    "held_out_rmse_after": 0.021,
}
FINDING: dict[str, Any] = {
    "effect": "friction.stribeck",
    "name": "Stribeck friction",
    "status": "ambiguous",
    "confidence": 0.9,
    "channel": "motor_torque",
    "location": {"text": "below 2 deg/s"},
    "equation": "tau_m += f_s",
    "parameters": [{"symbol": "f_s", "value": 0.4, "unit": "N*m", "std": None}],
    "next_experiment": {"why": "they differ", "file": "next-1.toml", "points": []},
}


def _printed(capsys: pytest.CaptureFixture[str], channel: dict[str, Any], finding: dict[str, Any]) -> str:
    recordings = {"rejected": [{"file": "a.h5", "why": "a.h5 is short"}]}
    content = {"findings": [finding], "channels": [channel], "recordings": recordings, "notes": ["a note"]}
    _say(content, "Mismatch: something.", Path("out"))
    return capsys.readouterr().out


def test_findings_channels_and_what_was_not_used_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    out = _printed(capsys, CHANNEL, FINDING)
    for text in (
        "Mismatch: something.",
        "Stribeck friction (friction.stribeck): ambiguous, confidence 0.90",
        "in motor torque, below 2 deg/s",
        "f_s = 0.4 N*m",
        "bench run out/next-1.toml (they differ)",
        "noise 0.02; what is left: as given not computed, recalibrated 0.06, improved 0.021 (1.050 of the noise)",
        "not used: a.h5 is short",
        "note: a note",
    ):
        assert text in out


def test_what_is_null_is_said_to_be(capsys: pytest.CaptureFixture[str]) -> None:
    scores = dict.fromkeys(("held_out_rmse_before", "held_out_rmse_after", "in_sample_rmse_as_given"))
    channel = CHANNEL | scores | {"in_sample_rmse_before": 0.06, "in_sample_rmse_after": 0.02}
    values = [{"symbol": "c", "value": None, "unit": "1", "std": None}]
    out = _printed(capsys, channel, FINDING | {"confidence": None, "parameters": values})
    assert "confidence not computed" in out
    assert "c = not computed\n" in out
    assert "improved 0.02 (1.000 of the noise), on what was fitted: nothing could be held out" in out


def test_a_linear_axis_has_a_force(capsys: pytest.CaptureFixture[str]) -> None:
    assert "in motor force, below 2 deg/s" in _printed(capsys, CHANNEL | {"unit": "N"}, FINDING)


@pytest.mark.parametrize(
    ("scores", "recalibrated", "words"),
    [
        ([(0.06, 0.02), (1.0, 1.0)], ["friction.coulomb.f_c"], "improved simulation"),
        ([(0.06, 0.06)], ["friction.coulomb.f_c"], "recalibrated simulation"),
        ([(None, None)], [], "simulation as given"),
        ([], [], "simulation as given"),
    ],
)
def test_what_the_model_holds_is_said_as_the_scores_say(
    scores: list[tuple[float | None, float | None]], recalibrated: list[str], words: str
) -> None:
    assert kind_of_simulation(scores, recalibrated) == words
