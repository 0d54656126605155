"""Scoring on hand-made reports: it must give credit where due and be able to fail everything."""

from __future__ import annotations

import copy
import math
from typing import Any

import pytest

from bench.proof.score import score

NOISE = {"transmission_error": 4e-6, "motor_torque": 0.05, "temperature": 0.02, "load_torque": 2.0}


def concealed(effect: str = "friction.stribeck", **changes: Any) -> dict[str, Any]:
    base: dict[str, Any] = {
        "effect": effect,
        "status": "named",
        "form": "any",
        "channels": ["motor_torque"],
        "strength": 1.2,
        "location": {"conditions": {}, "orders": [], "angle_windows": [], "time_window": None},
        "parameters": [{"symbol": "f_s", "value": 0.2, "unit": "N·m"}],
        "also": [],
    }
    location = changes.pop("location", {})
    base["location"] |= location
    return base | changes


def truth(*effects: dict[str, Any]) -> dict[str, Any]:
    verdict = "mismatch" if effects else "match"
    return {"case": "c", "group": "g", "verdict": verdict, "effects": list(effects), "noise_rms": NOISE}


def finding(effect: str = "friction.stribeck", **changes: Any) -> dict[str, Any]:
    base: dict[str, Any] = {
        "effect": effect,
        "status": "named",
        "confidence": 0.95,
        "channel": "motor_torque",
        "location": {"conditions": {"direction": "both"}, "orders": [], "angle_windows": []},
        "parameters": [{"symbol": "f_s", "value": 0.21, "unit": "N·m", "std": 0.01}],
        "alternatives": [],
    }
    location = changes.pop("location", {})
    base["location"] |= location
    return base | changes


def report(*findings: dict[str, Any], after: float = 0.05) -> dict[str, Any]:
    channels = [{"channel": "motor_torque", "held_out_rmse_after": after}]
    return {"verdict": "mismatch" if findings else "match", "findings": list(findings), "channels": channels}


def test_everything_right() -> None:
    result = score(truth(concealed()), report(finding()), 3.0)
    assert result.every_point_right
    assert result.effects[0].parameter_errors == pytest.approx((0.05,))
    assert result.effects[0].covered == (True,)
    assert result.confidences == ((0.95, True),)
    assert result.residual == pytest.approx(1.0)


def test_null_with_match_is_right_and_with_a_finding_is_not() -> None:
    assert score(truth(), report(), 1.0).every_point_right
    alarmed = score(truth(), report(finding()), 1.0)
    assert not alarmed.every_point_right
    assert alarmed.false_companions == ("friction.stribeck",)
    assert alarmed.confidences == ((0.95, False),)


def test_wrong_name_is_both_missed_and_false() -> None:
    result = score(truth(concealed()), report(finding("friction.viscous_quadratic")), 1.0)
    assert not result.effects[0].status_right
    assert not result.effects[0].found
    assert result.false_companions == ("friction.viscous_quadratic",)


def test_a_false_companion_spoils_the_folder() -> None:
    result = score(truth(concealed()), report(finding(), finding("te.harmonic")), 1.0)
    assert result.effects[0].status_right
    assert result.false_companions == ("te.harmonic",)
    assert not result.every_point_right


def test_residual_too_large_spoils_the_folder() -> None:
    result = score(truth(concealed()), report(finding(), after=0.056), 1.0)
    assert result.residual == pytest.approx(1.12)
    assert not result.every_point_right


def test_a_residual_below_the_noise_is_not_believed() -> None:
    assert not score(truth(concealed()), report(finding(), after=0.03), 1.0).every_point_right


def test_unknown_called_by_a_name_is_wrong() -> None:
    hidden = truth(concealed("unknown", status="unknown", parameters=[]))
    assert not score(hidden, report(finding("friction.run_in")), 1.0).effects[0].status_right
    honest = report(finding("unknown", status="unknown"), after=0.2)
    assert score(hidden, honest, 1.0).every_point_right
    both = report(finding("unknown", status="unknown"), finding("friction.run_in"))
    assert not score(hidden, both, 1.0).effects[0].status_right


def test_unknown_in_another_channel_does_not_answer() -> None:
    hidden = truth(concealed("unknown", status="unknown"))
    elsewhere = report(finding("unknown", status="unknown", channel="temperature"))
    result = score(hidden, elsewhere, 1.0)
    assert not result.effects[0].status_right
    assert result.false_companions == ("unknown",)


def test_unknown_for_a_named_effect_is_neither_right_nor_a_companion() -> None:
    result = score(truth(concealed()), report(finding("unknown", status="unknown")), 1.0)
    assert not result.effects[0].status_right
    assert result.false_companions == ()
    assert result.confidences == ((0.95, False),)


AMBIGUOUS = {"status": "ambiguous", "also": ["te.hysteresis"], "channels": ["transmission_error"]}


@pytest.mark.parametrize("told", ["te.lost_motion", "te.hysteresis"])
def test_ambiguous_needs_both_names(told: str) -> None:
    hidden = truth(concealed("te.lost_motion", **AMBIGUOUS))
    other = "te.hysteresis" if told == "te.lost_motion" else "te.lost_motion"
    pair = finding(told, status="ambiguous", channel="transmission_error", alternatives=[{"effect": other}])
    result = score(hidden, report(pair), 1.0).effects[0]
    assert result.status_right
    assert result.parameter_errors == ()
    alone = copy.deepcopy(pair) | {"alternatives": []}
    assert not score(hidden, report(alone), 1.0).effects[0].status_right
    sure = copy.deepcopy(pair) | {"status": "named"}
    assert not score(hidden, report(sure), 1.0).effects[0].status_right


def test_ambiguous_told_of_a_clear_effect_is_not_right() -> None:
    told = finding(status="ambiguous", alternatives=[{"effect": "friction.run_in"}])
    result = score(truth(concealed()), report(told), 1.0)
    assert result.effects[0].found
    assert not result.effects[0].status_right
    assert result.false_companions == ()


@pytest.mark.parametrize(
    ("true", "told", "right"),
    [
        ({"orders": [48.0]}, {"orders": [48.0]}, True),
        ({"orders": [48.0]}, {"orders": [48.3]}, True),
        ({"orders": [48.0]}, {"orders": [49.0]}, False),
        ({"orders": [48.0]}, {"orders": []}, False),
        ({"orders": [45.0, 47.0]}, {"orders": [45.0, 47.0]}, True),
        ({"orders": [45.0, 47.0]}, {"orders": [40.0, 41.0, 42.0, 45.0]}, False),
        ({"angle_windows": [[6.2, 6.4]]}, {"angle_windows": [[0.0, 0.2]]}, True),
        ({"angle_windows": [[1.0, 1.2]]}, {"angle_windows": [[2.0, 2.2]]}, False),
        ({"angle_windows": [[1.0, 1.2]]}, {"angle_windows": [[0.0, 6.2]]}, False),
        ({"conditions": {"velocity": [0.0, 0.05]}}, {"conditions": {"velocity": [0.0, 0.02]}}, True),
        ({"conditions": {"velocity": [0.0, 0.05]}}, {"conditions": {"velocity": [0.1, 0.2]}}, False),
        ({"conditions": {"direction": "positive"}}, {"conditions": {"direction": "negative"}}, False),
        ({"conditions": {"direction": "positive"}}, {"conditions": {"direction": "positive"}}, True),
        ({}, {"orders": [3.0]}, True),
    ],
)
def test_place(true: dict[str, Any], told: dict[str, Any], right: bool) -> None:
    result = score(truth(concealed(location=true)), report(finding(location=told)), 1.0)
    assert result.effects[0].located_right is right
    assert result.every_point_right is right


def test_wrong_channel_is_not_located() -> None:
    assert not score(truth(concealed()), report(finding(channel="temperature")), 1.0).effects[0].located_right


def test_no_report_fails_every_point_even_of_a_null() -> None:
    result = score(truth(), None, 1.0, "exit code 1: broken")
    assert not result.verdict_right
    assert not result.every_point_right
    assert math.isnan(result.residual)


def test_two_findings_of_one_name_count_once() -> None:
    result = score(truth(concealed()), report(finding(), finding(confidence=0.4)), 1.0)
    assert result.false_companions == ("friction.stribeck",)


def test_compound_pairs_each_effect_with_its_own_finding() -> None:
    both = truth(concealed(), concealed("te.harmonic", channels=["transmission_error"], parameters=[]))
    told = report(finding("te.harmonic", channel="transmission_error"), finding())
    result = score(both, told, 1.0)
    assert [e.status_right for e in result.effects] == [True, True]
    assert result.false_companions == ()
