"""Every figure of the report, recomputed from what it was made of by plain sums."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.discovery import ChannelOutcome, Discovery, RefittedAlternative
from bench.mismatch.report.content import Compared
from bench.mismatch.report.figures import square_error
from bench.mismatch.report.finding import conclude
from bench.mismatch.report.report import Report
from bench.mismatch.report.verdict import judged
from tests.bench.mismatch.report import made


def _report(held: Any = made.HELD_OUT, **more: Any) -> tuple[dict[str, Any], Discovery, ChannelOutcome]:
    frame = made.campaign()
    others = made.outcome(frame, "motor_torque", [], held=held)
    worse = others.left + 0.5 * made.stribeck(frame)
    alternatives = (made.alternative("friction.viscous_quadratic", worse), made.alternative("unknown", None, True))
    added = made.stribeck(frame)
    found = made.discovery("motor_torque", "friction.stribeck", added, ("speed",), alternatives=alternatives, **more)
    own = made.outcome(frame, "motor_torque", [found], held=held)
    data = made.dataset(frame, "motor_torque", own.rows, held=held)
    findings = conclude([own], data)
    report = Report(
        *judged([own], findings), data, [own], findings, ["no load_angle"], simulation=Compared("model", "m")
    )
    text = json.dumps(report.to_json(), allow_nan=False)
    return json.loads(text), found, own


def _mean(values: Any, own: ChannelOutcome, rows: Any) -> float:
    total = number = 0.0
    for k in np.flatnonzero(rows):
        total += float(values[k]) * float(own.rows.number[k])
        number += float(own.rows.number[k])
    return total / number


def test_every_figure_is_what_its_name_says() -> None:
    told, found, own = _report()
    assert (told["format"], told["format_version"], told["verdict"]) == ("bench-mismatch-report", "1.1", "mismatch")
    assert told["simulation"] == {"kind": "model", "file": "m", "recalibrated": []}
    assert told["recordings"]["held_out"] == [f"r{k:02d}" for k in made.HELD_OUT]
    channel = told["channels"][0]
    assert (channel["held_out_rmse_as_given"], channel["held_out_rmse_before"]) == (None, 0.06)
    assert (channel["noise_floor"], channel["held_out_rmse_after"]) == (own.floor, 0.02)
    assert channel["structure"]["p_value"] == 0.3
    assert "in_sample_rmse_after" not in channel
    finding = told["findings"][0]
    gained = _mean((own.left + found.added) ** 2 - own.left**2, own, own.held_out)
    evidence = finding["evidence"]
    assert evidence["held_out_rmse_before"] == pytest.approx(math.sqrt(0.02**2 + gained))
    assert evidence["held_out_rmse_after"] == 0.02
    assert evidence["p_value"] == 1e-3
    share = gained / (0.02**2 + gained - own.floor**2)
    assert finding["location"]["share_of_excess"] == pytest.approx(share)
    second, first = finding["alternatives"]
    assert (second["as_good"], first["as_good"]) == (True, False)
    left = own.left + 0.5 * found.added
    rmse = math.sqrt(0.02**2 + _mean(left**2 - own.left**2, own, own.held_out))
    assert first["held_out_rmse"] == pytest.approx(rmse)
    assert "5.0 ± 2.0 less log density" in first["why_not"]
    assert second["held_out_rmse"] is None
    assert "cannot tell the two apart" in second["why_not"]
    assert finding["location"]["conditions"]["velocity"] == pytest.approx([0.02, 0.06])
    assert set(finding["location"]["span"]) == {"velocity", "load_torque", "temperature"}


def test_where_nothing_is_held_out_figures_are_of_what_was_fitted_and_say_so() -> None:
    told, found, own = _report(held=())
    channel, finding = told["channels"][0], told["findings"][0]
    assert channel["held_out_rmse_after"] is None
    assert channel["in_sample_rmse_after"] == 0.02
    gained = _mean((own.left + found.added) ** 2 - own.left**2, own, own.usable)
    assert finding["evidence"]["held_out_rmse_before"] is None
    assert finding["evidence"]["in_sample_rmse_before"] == pytest.approx(math.sqrt(0.02**2 + gained))
    assert finding["location"]["share_of_excess"] is None
    assert finding["alternatives"][0]["held_out_rmse"] is None
    assert finding["alternatives"][1]["in_sample_rmse"] is not None


def test_what_is_no_number_is_null() -> None:
    told, _, _ = _report(
        p_value=None,
        confidence=None,
        parameters=({"symbol": "c", "value": np.float64(1.0), "unit": "1", "std": math.nan},),
        table=({"order": 5.0, "amplitude": math.inf},),
    )
    finding = told["findings"][0]
    assert finding["confidence"] is None
    assert finding["evidence"]["p_value"] is None
    assert finding["parameters"][0] == {"symbol": "c", "value": 1.0, "unit": "1", "std": None}
    assert finding["table"] == [{"order": 5.0, "amplitude": None}]


def test_squares_count_where_rows_are_too_coarse() -> None:
    told, _, own = _report(squares=(5e-4, 4e-4))
    evidence = told["findings"][0]["evidence"]
    assert evidence["held_out_rmse_before"] == pytest.approx(math.sqrt(0.02**2 + 1e-4))
    share = told["findings"][0]["location"]["share_of_excess"]
    assert share == pytest.approx(1e-4 / (0.02**2 + 1e-4 - own.floor**2))


def test_a_share_that_cannot_be_computed_is_null() -> None:
    frame = made.campaign()
    found = made.discovery("motor_torque", "friction.stribeck", np.zeros(frame.size), ("speed",))
    own = made.outcome(frame, "motor_torque", [found])
    own.floor = 0.03
    finding = conclude([own], made.dataset(frame, "motor_torque", own.rows))[0]
    assert finding.share_of_excess is None
    assert finding.before == pytest.approx(finding.after)


def test_a_share_is_no_more_than_all_where_less_than_the_floor_is_left() -> None:
    frame = made.campaign()
    found = made.discovery("motor_torque", "friction.stribeck", 0.05 * np.sign(frame.velocity), ("speed",))
    own = made.outcome(frame, "motor_torque", [found])
    after = own.rmse["after"]
    assert after is not None
    own.floor = 1.2 * after
    assert conclude([own], made.dataset(frame, "motor_torque", own.rows))[0].share_of_excess == pytest.approx(1.0)


def test_one_finding_an_effect_the_strongest_first() -> None:
    frame = made.campaign()
    weak = made.discovery("motor_torque", "load.unbalance", np.full(frame.size, 0.1), ("angle",))
    strong = made.discovery("load_torque", "load.unbalance", np.full(frame.size, 90.0), ("angle",))
    other = made.discovery("motor_torque", "friction.stribeck", np.full(frame.size, 0.3), ("speed",))
    odd = [made.discovery(c, "unknown", np.full(frame.size, 1e-3), ("time",)) for c in ("motor_torque", "load_torque")]
    motor = made.outcome(frame, "motor_torque", [weak, other, odd[0]])
    load = made.outcome(frame, "load_torque", [strong, odd[1]], sigma=1.5)
    found = conclude([motor, load], made.dataset(frame, "motor_torque", motor.rows))
    assert [(f.effect, f.channel) for f in found][:2] == [
        ("load.unbalance", "load_torque"),
        ("friction.stribeck", "motor_torque"),
    ]
    assert found[0].also_in == ("motor_torque",)
    assert [f.channel for f in found[2:]] == ["motor_torque", "load_torque"]


def test_what_depends_on_an_auxiliary_quantity_is_called_so_and_stands_by_itself() -> None:
    frame = made.campaign()
    oil = made.discovery("motor_torque", "unknown", np.full(frame.size, 0.3), ("aux/oil",), status="unknown")
    other = made.discovery("motor_torque", "unknown", np.full(frame.size, 0.1), ("time",), status="unknown")
    own = made.outcome(frame, "motor_torque", [oil, other])
    found = conclude([own], made.dataset(frame, "motor_torque", own.rows))
    assert [f.effect for f in found] == ["unknown", "unknown"]
    assert found[0].name == "something that depends on aux/oil"
    assert "aux" not in found[1].name


def test_a_hopeless_probability_is_told_as_a_bound() -> None:
    frame = made.campaign()
    alternative = RefittedAlternative("friction.presliding", "pre-sliding", 700.0, 10.0, 7.6e-300, False)
    own = made.outcome(
        frame,
        "motor_torque",
        [made.discovery("motor_torque", "unknown", np.ones(frame.size), ("speed",), alternatives=(alternative,))],
    )
    (finding,) = conclude([own], made.dataset(frame, "motor_torque", own.rows))
    assert "e-" not in finding.alternatives[0].why_not
    assert "probability below 0.001" in finding.alternatives[0].why_not


def test_several_of_one_effect_in_a_channel_are_one() -> None:
    frame = made.campaign()
    added = made.stribeck(frame)
    parts = [made.discovery("motor_torque", "friction.stribeck", k * added, ("speed",), gain=k) for k in (1.0, 2.0)]
    own = made.outcome(frame, "motor_torque", parts)
    found = conclude([own], made.dataset(frame, "motor_torque", own.rows))
    assert len(found) == 1
    assert len(found[0].discovery.parameters) == 2
    gained = _mean((own.left + 3.0 * made.stribeck(frame)) ** 2 - own.left**2, own, own.held_out)
    assert found[0].before == pytest.approx(math.sqrt(0.02**2 + gained))


@pytest.mark.parametrize(
    ("change", "verdict", "words"),
    [
        ({}, "match", ""),
        ({"rmse": {"after": 0.031}}, "undetermined", "more than the noise"),
        ({"rmse": {}}, "undetermined", "could be held out"),
        ({"floor_std": None}, "undetermined", "how well that noise is known could not be computed"),
        ({"structure": None}, "undetermined", "could not be tested"),
    ],
)
def test_a_match_is_a_claim_that_was_tested(change: dict[str, Any], verdict: str, words: str) -> None:
    frame = made.campaign()
    own = made.outcome(frame, "motor_torque", [])
    own.floor = 0.0195
    own = replace(own, **{"floor_std": 0.0005} | change)
    said = judged([own], ())
    assert said[0] == verdict
    assert words in said[1]


def test_what_is_left_is_known_as_well_as_recordings_agree() -> None:
    frame = made.campaign()
    own = made.outcome(frame, "motor_torque", [])
    means = [_mean(own.left**2, own, own.held_out & (frame.recording == k)) for k in made.HELD_OUT]
    error = square_error(own)
    assert error == pytest.approx(np.std(means, ddof=1) / math.sqrt(len(means)), rel=0.05)
    one = made.outcome(frame, "motor_torque", [], held=(3,))
    assert square_error(one) is None
    # recordings that differ more leave more room
    rows = np.where(frame.recording == made.HELD_OUT[0], 4.0, 1.0) * own.left
    own.rows = replace(own.rows, y=own.whole + rows)
    own = replace(own, floor=0.0195, floor_std=0.0005, rmse={"after": 0.0225})
    assert judged([own], ())[0] == "match"


def test_structure_without_a_finding_is_no_match() -> None:
    frame = made.campaign()
    own = made.outcome(frame, "motor_torque", [])
    assert own.structure is not None
    own.structure = replace(own.structure, p_value=1e-4)
    assert judged([own], ())[0] == "undetermined"


def test_a_few_recordings_far_off_are_no_match() -> None:
    """The median recording is at the noise, all together are at twice as much."""
    frame = made.campaign()
    own = made.outcome(frame, "motor_torque", [])
    own = replace(own, floor=0.0195, floor_std=0.0005, rmse={"after": 0.039, "after_steady": 0.0196})
    verdict, why = judged([own], ())
    assert verdict == "undetermined"
    assert "a few recordings" in why
    own = replace(own, rmse={"after": 0.0205, "after_steady": 0.0196})
    assert judged([own], ())[0] == "match"


@pytest.mark.parametrize(("shares", "half_as_sure"), [((0.0, 0.0), False), ((0.3, 0.75), False), ((1.0, 1.0), True)])
def test_what_held_out_recordings_do_not_bear_out_is_half_as_sure(
    shares: tuple[float, float], half_as_sure: bool
) -> None:
    """A finding whose removal predicts them better, by more than recordings differ in that."""
    frame = made.campaign()
    share = np.where(np.searchsorted(made.HELD_OUT, frame.recording) % 2 == 0, *shares)
    found = made.discovery("motor_torque", "friction.stribeck", made.stribeck(frame), ("speed",), confidence=0.8)
    own = made.outcome(frame, "motor_torque", [found])
    # the model has the effect, of what was measured a share is missing
    own = replace(own, rows=replace(own.rows, y=own.rows.y - share * found.added))
    finding = conclude([own], made.dataset(frame, "motor_torque", own.rows))[0]
    assert finding.against is half_as_sure
    sure = conclude([made.outcome(frame, "motor_torque", [found])], made.dataset(frame, "motor_torque", own.rows))[0]
    assert finding.discovery.confidence == pytest.approx((0.5 if half_as_sure else 1.0) * sure.discovery.confidence)
