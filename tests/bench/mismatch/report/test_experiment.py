"""The next experiment: accepted by the bench, within what it can do, and it separates the alternatives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.campaigns import load_campaign, make_plan
from bench.configuration import load_bench
from bench.mismatch.report.candidates import Candidate, Range, candidates, frame_of
from bench.mismatch.report.experiment import campaign, proposed
from bench.mismatch.report.finding import Finding, conclude
from bench.mismatch.report.rules import RULES, by_rule
from bench.mismatch.report.separating import separating
from bench.simulation.frame import Frame
from bench.simulation.terms import LIBRARY
from tests.bench.mismatch.report import made

COVERED = made.COVERED


def _ambiguous(frame: Frame, alternative: str = "friction.stribeck") -> tuple[Finding, Any]:
    """Churning, of which Stribeck friction is told to be as good."""
    form = LIBRARY["friction.viscous_quadratic"].forms["motor_torque"][0]
    added = form.columns(frame, ())[:, 0] * 0.06
    row = {
        "effect": "friction.viscous_quadratic",
        "form": form.name,
        "point": [],
        "channels": ["motor_torque"],
        "parameters": {form.linear[0].symbol: {"value": 0.06, "unit": "1"}},
    }
    found = made.discovery(
        "motor_torque",
        "friction.viscous_quadratic",
        added,
        ("speed",),
        status="ambiguous",
        simulation_rows=(row,),
        alternatives=(made.alternative(alternative, None, True),),
    )
    own = made.outcome(frame, "motor_torque", [found])
    data = made.dataset(frame, "motor_torque", own.rows)
    return conclude([own], data)[0], data


def _upper_speeds() -> Frame:
    frame = made.campaign()
    return frame.take(np.abs(frame.velocity) > 0.05)


def test_points_are_chosen_where_two_laws_differ_most() -> None:
    frame = made.campaign()
    fast = frame.take(np.abs(frame.velocity) > 0.05)
    numbers = np.unique(fast.recording, return_inverse=True)[1].astype(np.int64)
    finding, data = _ambiguous(replace(fast, recording=numbers))
    proposal = separating(finding, Range.of(data), data.ratio)
    assert proposal is not None
    slowest = min(abs(p.velocity) for p in proposal.points)
    assert slowest < 0.05 or any(p.sequence == "velocity_ramp" for p in proposal.points)
    assert "quadratic" in proposal.why or "churning" in proposal.why.lower()
    assert "Stribeck friction" in proposal.why


def test_a_rival_that_is_no_regressor_is_asked_by_rule(tmp_path: Path) -> None:
    finding, data = _ambiguous(made.campaign(), "unknown")
    assert separating(finding, Range.of(data), data.ratio) is None
    (told,) = proposed([finding], data, tmp_path)
    assert told.next_experiment is not None
    assert "laws of speed" in told.next_experiment.why


def test_the_file_is_a_campaign_within_the_limits(tmp_path: Path) -> None:
    finding, data = _ambiguous(made.campaign())
    named = replace(finding, discovery=replace(finding.discovery, status="named"))
    first, second = proposed([named, finding], data, tmp_path)
    assert first.next_experiment is None
    assert second.next_experiment is not None
    assert made.write_nothing(tmp_path) == ["next-1.toml"]
    plan = make_plan(load_campaign(tmp_path / second.next_experiment.file), load_bench("rh380n").configuration)
    assert plan.points == len(second.next_experiment.points)


@pytest.mark.parametrize("rule", RULES, ids=lambda r: r.why[:20])
def test_every_rule_can_be_planned(rule: Any, tmp_path: Path) -> None:
    points = list(rule.points(replace(COVERED, warmest=30.0)))
    path = tmp_path / "rule.toml"
    path.write_text(campaign("all", 1, points), encoding="utf-8")
    assert make_plan(load_campaign(path), load_bench("rh380n").configuration).points == len(points) > 0


def test_a_bench_that_does_not_warm_up_is_not_asked_to() -> None:
    cold = replace(COVERED, heats=False, sides=(-1.0,), torque_sides=(1.0,))
    listed = [*candidates(cold), *(p for rule in RULES for p in rule.points(cold))]
    assert all(p.temperature is None for p in listed)
    assert {p.sequence for p in listed} <= {"constant_velocity", "velocity_ramp", "dwell"}
    assert all(p.velocity <= 0.0 for p in listed)
    assert all(0.0 <= p.torque <= cold.torque for p in listed)


def test_the_range_is_read_from_the_recordings() -> None:
    frame = made.campaign()
    own = made.outcome(frame, "motor_torque", [])
    covered = Range.of(made.dataset(frame, "motor_torque", own.rows))
    assert (covered.torque, covered.slowest, covered.fastest) == (1000.0, 0.02, 0.17)
    assert covered.sides == covered.torque_sides == (1.0, -1.0)
    assert covered.heats
    still = made.campaign(temperature=False)
    own = made.outcome(still, "motor_torque", [])
    assert not Range.of(made.dataset(still, "motor_torque", own.rows)).heats
    heated = made.dataset(still, "motor_torque", own.rows, {3: "heating"})
    assert Range.of(heated).heats
    assert Range.of(heated).warm is None


def test_every_candidate_can_be_planned(tmp_path: Path) -> None:
    listed = list(candidates(replace(COVERED, warmest=30.0)))
    assert {c.sequence for c in listed} == {"constant_velocity", "reversal", "torque_ramp", "velocity_ramp"}
    some = [listed[i] for i in np.linspace(0, len(listed) - 1, 12).astype(int)]
    path = tmp_path / "all.toml"
    path.write_text(campaign("all", 1, some), encoding="utf-8")
    assert make_plan(load_campaign(path), load_bench("rh380n").configuration).points == len(some)


@pytest.mark.parametrize("candidate", list(candidates(COVERED))[::17], ids=lambda c: f"{c.sequence} {c.torque:g}")
def test_a_candidates_rows_are_its_motion(candidate: Candidate) -> None:
    frame = frame_of(candidate, COVERED, made.RATIO)
    assert np.abs(frame.velocity).max() == pytest.approx(abs(candidate.velocity))
    assert np.abs(frame.torque).max() == pytest.approx(abs(candidate.torque))
    assert np.all(np.diff(frame.travel) > 0)
    if candidate.sequence == "reversal":
        assert set(frame.last_direction) == {1.0, -1.0}
        assert frame.reversed_before.max() == 1.0


def test_an_unknown_in_the_temperature_is_asked_by_heating() -> None:
    frame = made.campaign()
    found = made.discovery("temperature", "unknown", np.sin(frame.time), ("time",))
    own = made.outcome(frame, "temperature", [found])
    finding = conclude([own], made.dataset(frame, "temperature", own.rows))[0]
    asked = by_rule(finding, COVERED)
    assert asked is not None
    assert [p.sequence for p in asked.points] == ["heating", "dwell", "cooling", "heating"]
    without = by_rule(finding, replace(COVERED, heats=False))
    assert without is not None
    assert {p.sequence for p in without.points} == {"constant_velocity", "dwell"}
