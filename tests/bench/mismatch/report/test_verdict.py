"""What is called a match: a few recordings of the transmission error that leave more than noise are none."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from bench.mismatch.report import verdict
from bench.mismatch.report.verdict import judged
from bench.simulation.terms import MOTOR_TORQUE, TRANSMISSION_ERROR


def outcome(channel: str, altogether: float, doubt: float = 0.0, usual: float = 1.05) -> Any:
    """A channel that leaves so many times its noise of the held-out recordings together, and of the usual one."""
    return SimpleNamespace(
        channel=channel,
        structure=SimpleNamespace(p_value=0.5),
        settled=usual,
        altogether=altogether,
        floor=1.0,
        floor_std=0.01,
        doubt=doubt,
        of_levels=0.0,
        rmse={"after": altogether},
    )


@pytest.mark.parametrize(
    ("channel", "altogether", "doubt", "told"),
    [
        (TRANSMISSION_ERROR, 1.1, 0.0, "match"),
        (TRANSMISSION_ERROR, 1.48, 0.2, "undetermined"),
        # where the calibration is unsure itself, by as much
        (TRANSMISSION_ERROR, 1.48, 0.6, "match"),
        # torques waver with the control loops
        (MOTOR_TORQUE, 1.48, 0.0, "match"),
        (MOTOR_TORQUE, 1.9, 0.0, "undetermined"),
    ],
)
def test_a_few_recordings_far_off(
    monkeypatch: pytest.MonkeyPatch, channel: str, altogether: float, doubt: float, told: str
) -> None:
    monkeypatch.setattr(verdict, "square_error", lambda _: 0.2)
    said, why = judged([outcome(channel, altogether, doubt)], [])
    assert said == told
    assert ("a few recordings leave more" in why) == (told == "undetermined")


def test_what_is_left_of_the_usual_recording_is_asked_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(verdict, "square_error", lambda _: 0.02)
    said, why = judged([outcome(TRANSMISSION_ERROR, 1.5, usual=1.5)], [])
    assert said == "undetermined"
    assert why.startswith("what is left of the transmission error")
