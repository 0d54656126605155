"""Scoring on hand-made reports: it must give credit where due and be able to fail everything."""

from __future__ import annotations

import copy
import math
from typing import Any

import pytest

from bench.proof.score import names_of, score

#: What the examiner works out itself of a model that holds the term to 5 %.
OWN: dict[str, Any] = {
    "residual": {"motor_torque": 1.0},
    "shares": {"0": 0.8},
    "parameters": {"friction.stribeck": {"f_s": [0.21, 0.01]}},
    "predictor": True,
    "why": "",
}
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


def test_what_the_report_could_not_compute_is_not_scored() -> None:
    parameters = [{"symbol": "f_s", "value": None, "unit": "N·m", "std": None}]
    result = score(truth(concealed()), report(finding(confidence=None, parameters=parameters)), 3.0)
    assert result.every_point_right
    assert result.confidences == ()
    assert result.effects[0].parameter_errors == ()


def test_an_alternative_that_is_not_as_good_is_not_open() -> None:
    rivals = [{"effect": "friction.presliding", "as_good": False}, {"effect": "friction.run_in", "as_good": True}]
    told = finding(status="ambiguous", alternatives=rivals)
    assert names_of(told) == {"friction.stribeck", "friction.run_in"}


def test_everything_right() -> None:
    result = score(truth(concealed()), report(finding()), 3.0, recomputed=OWN)
    assert result.every_point_right
    assert result.recomputed
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


def test_what_nobody_could_see_asks_for_nothing() -> None:
    faint = concealed() | {"too_faint": True}
    for told in (report(), report(finding()), report(finding(status="ambiguous"))):
        result = score(truth(faint), told, 1.0)
        assert result.every_point_right
        assert (result.counted, result.confidences) == ((), ())
    assert score(truth(faint), report(finding("friction.viscous_quadratic")), 1.0).false_companions
    # of two alike the one that could be seen is answered
    both = score(truth(faint, concealed()), report(finding()), 1.0, recomputed=OWN)
    assert [e.status_right for e in both.counted] == [True]
    assert both.every_point_right


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


def test_what_the_report_tells_of_its_residual_and_parameters_is_not_believed() -> None:
    flattering = report(finding(), after=0.05)
    worse = OWN | {"residual": {"motor_torque": 1.12}}
    result = score(truth(concealed()), flattering, 1.0, recomputed=worse)
    assert result.residual == pytest.approx(1.12)
    assert not result.every_point_right
    other = OWN | {"parameters": {"friction.stribeck": {"f_s": [0.3, 0.01]}}}
    result = score(truth(concealed()), flattering, 1.0, recomputed=other)
    assert result.effects[0].parameter_errors == pytest.approx((0.5,))
    assert result.effects[0].covered == (False,)


def test_without_a_prediction_the_score_says_whose_residual_it_is() -> None:
    result = score(truth(concealed()), report(finding(), after=0.056), 1.0)
    assert result.residual == pytest.approx(1.12)
    assert not result.recomputed


def test_a_model_that_does_not_predict_is_not_right_whatever_the_report_tells() -> None:
    broken = OWN | {"residual": {}, "why": "there is no model.json"}
    result = score(truth(concealed()), report(finding(), after=0.05), 1.0, recomputed=broken)
    assert math.isnan(result.residual)
    assert not result.every_point_right


def test_signs_count() -> None:
    turned = OWN | {"parameters": {"friction.stribeck": {"f_s": [-0.2, 0.01]}}}
    result = score(truth(concealed()), report(finding()), 1.0, recomputed=turned)
    assert result.effects[0].parameter_errors == pytest.approx((2.0,))
    assert result.effects[0].covered == (False,)


def test_the_told_share_is_compared_with_the_recomputed_one() -> None:
    told = finding(location={"share_of_excess": 0.95})
    result = score(truth(concealed()), report(told), 1.0, recomputed=OWN)
    assert result.effects[0].share_error == pytest.approx(0.15)


def test_a_residual_below_the_noise_is_not_believed() -> None:
    assert not score(truth(concealed()), report(finding(), after=0.025), 1.0).every_point_right


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


def test_an_alternative_that_the_report_calls_worse_is_not_counted() -> None:
    hidden = truth(concealed("te.lost_motion", **AMBIGUOUS))

    def right(**words: Any) -> bool:
        pair = finding(
            "te.lost_motion",
            status="ambiguous",
            channel="transmission_error",
            alternatives=[{"effect": "te.hysteresis", **words}],
        )
        return score(hidden, report(pair), 1.0).effects[0].status_right

    assert right(why_not="explains the recordings as well: they cannot tell the two apart")
    assert right(why_not=None)
    assert right(as_good=True, why_not="12 of log-likelihood")
    assert not right(why_not="loses 40 of log-likelihood on recordings left out")
    assert not right(as_good=False)


def test_ambiguous_told_of_a_clear_effect_is_not_right() -> None:
    told = finding(status="ambiguous", alternatives=[{"effect": "friction.run_in"}])
    result = score(truth(concealed()), report(told), 1.0)
    assert result.effects[0].found
    assert not result.effects[0].status_right
    assert result.false_companions == ()


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


def test_weak_orders_count_by_their_energy() -> None:
    sizes = [8e-6, *[1e-6] * 9]
    place = {"orders": [7.0, *range(30, 48, 2)], "order_sizes": sizes}
    weak = concealed("te.harmonic", channels=["transmission_error"], location=place)

    def told(*orders: float) -> bool:
        answer = finding("te.harmonic", channel="transmission_error", location={"orders": list(orders)})
        return score(truth(weak), report(answer), 1.0).effects[0].located_right

    assert told(7.0)
    assert not told(*range(30, 48, 2))
    assert not told(7.0, 11.0, 13.0)


def test_an_unknown_beside_weak_orders_is_recognised() -> None:
    strange = concealed("unknown", status="unknown", channels=["transmission_error"])
    weak = concealed("te.harmonic", channels=["transmission_error"])
    findings = [
        finding("unknown", status="unknown", channel="transmission_error"),
        finding("te.harmonic", channel="transmission_error"),
    ]
    assert [e.status_right for e in score(truth(strange, weak), report(*findings), 1.0).effects] == [True, True]
    false = finding("te.sideband", channel="transmission_error")
    assert not score(truth(strange, weak), report(*findings, false), 1.0).effects[0].status_right
