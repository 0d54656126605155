"""The design of the next experiment, where the best one is known."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bench.configuration import BenchConfiguration, load_bench
from bench.investigate.design import LEAST_GAIN, LEAST_POINTS, MOST_POINTS, bench_needs, best, by_rules
from bench.investigate.log import outcome_of
from bench.investigate.offer import extended_range, offered_points, states
from bench.investigate.questions import questions
from bench.mismatch.report.candidates import Range
from bench.mismatch.report.finding import Finding, conclude
from bench.simulation.frame import Frame
from bench.simulation.terms import LIBRARY
from tests.bench.mismatch.report import made

CELSIUS = 24.0


@pytest.fixture(scope="module")
def bench() -> BenchConfiguration:
    return load_bench("rh380n").configuration


def _fast() -> Frame:
    """Nothing slow: where friction that falls with speed looks like friction that grows with its square."""
    frame = made.campaign()
    fast = frame.take(np.abs(frame.velocity) > 0.05)
    return replace(fast, recording=np.unique(fast.recording, return_inverse=True)[1].astype(np.int64))


def _finding(frame: Frame, alternative: str = "friction.stribeck", **more: Any) -> tuple[Finding, Any]:
    """Churning, of which ``alternative`` is as good."""
    form = LIBRARY["friction.viscous_quadratic"].forms["motor_torque"][0]
    added = form.columns(frame, ())[:, 0] * 0.06
    row = {
        "effect": "friction.viscous_quadratic",
        "form": form.name,
        "point": [],
        "channels": ["motor_torque"],
        "parameters": {form.linear[0].symbol: {"value": 0.06, "unit": "1"}},
    }
    values: dict[str, Any] = {"status": "ambiguous", "alternatives": (made.alternative(alternative, None, True),)}
    found = made.discovery(
        "motor_torque", "friction.viscous_quadratic", added, ("speed",), simulation_rows=(row,), **(values | more)
    )
    # noise of a sample: a third of the effect at its strongest
    outcome = made.outcome(frame, "motor_torque", [found], float(np.abs(added).max()) / 3.0)
    data = made.dataset(frame, "motor_torque", outcome.rows)
    return conclude([outcome], data)[0], data


def test_two_laws_of_speed_are_told_apart_by_slow_points_soon(bench: BenchConfiguration) -> None:
    finding, data = _finding(_fast())
    asked = questions([finding], 0.7)
    covered = extended_range(Range.of(data), bench)
    chosen, _ = best(asked, covered, data.ratio, bench, CELSIUS, 8.0)
    assert chosen is not None
    assert LEAST_POINTS <= len(chosen.points) <= MOST_POINTS
    # the laws part where nothing was run; a warm-up takes long and tells no more of a law of speed
    assert any(abs(p.velocity) < 0.05 or p.sequence == "velocity_ramp" for p in chosen.points)
    assert chosen.state == "as found"
    assert chosen.expected > LEAST_GAIN
    assert 0.0 < chosen.hours < 1.0


def test_where_the_bench_refuses_every_point_nothing_is_designed_and_it_says_why(
    bench: BenchConfiguration, monkeypatch: pytest.MonkeyPatch
) -> None:
    finding, data = _finding(_fast())
    asked = questions([finding], 0.7)
    monkeypatch.setattr("bench.investigate.design.offered_points", lambda *_: ([], ["the lubricant is too warm"]))
    chosen, refused = best(asked, extended_range(Range.of(data), bench), data.ratio, bench, CELSIUS, 8.0)
    assert chosen is None
    assert refused == ["the lubricant is too warm"]


def test_a_path_is_told_from_a_function_of_the_torque_by_a_staircase(bench: BenchConfiguration) -> None:
    frame = made.campaign()
    far = frame.take(np.abs(frame.torque) > 250.0)
    far = replace(far, recording=np.unique(far.recording, return_inverse=True)[1].astype(np.int64))
    form = LIBRARY["te.lost_motion"].forms["transmission_error"][0]
    added = form.columns(far, form.grid(far)[0])[:, 0] * 2e-5
    # it stands as a table of numbers: no row of the simulation says its form
    found = made.discovery(
        "transmission_error",
        "te.lost_motion",
        added,
        ("torque",),
        status="ambiguous",
        alternatives=(made.alternative("te.hysteresis", None, True),),
    )
    outcome = made.outcome(far, "transmission_error", [found], 4e-6)
    data = made.dataset(far, "transmission_error", outcome.rows)
    asked = questions(conclude([outcome], data), 0.7)
    chosen, _ = best(asked, extended_range(Range.of(data), bench), data.ratio, bench, CELSIUS, 8.0)
    assert chosen is not None
    assert chosen.points[0].sequence == "torque_ramp"


def test_an_experiment_beyond_the_budget_is_not_chosen(bench: BenchConfiguration) -> None:
    finding, data = _finding(_fast())
    covered = extended_range(Range.of(data), bench)
    assert best(questions([finding], 0.7), covered, data.ratio, bench, CELSIUS, 1e-3)[0] is None


def test_points_the_bench_cannot_do_are_not_offered_and_the_refusal_names_the_limit(bench: BenchConfiguration) -> None:
    finding, data = _finding(_fast())
    slow = bench.model_copy(update={"limits": bench.limits.model_copy(update={"load_torque": 500.0})})
    covered = replace(extended_range(Range.of(data), bench), torque=1000.0)
    state = next(iter(states(covered, slow, CELSIUS)))
    points, refused = offered_points(state, slow)
    assert points
    assert max(abs(o.point.torque) for o in points) <= 500.0
    assert any("limits.load_torque" in sentence for sentence in refused)
    assert finding.open


def test_one_direction_and_one_speed_are_no_bounds_of_the_bench(bench: BenchConfiguration) -> None:
    narrow = replace(made.COVERED, slowest=0.1, fastest=0.1, sides=(1.0,), torque_sides=(1.0,))
    wide = extended_range(narrow, bench)
    assert wide.sides == wide.torque_sides == (1.0, -1.0)
    assert wide.fastest > narrow.fastest
    assert wide.fastest * bench.gearbox.ratio < bench.limits.motor_speed


def test_a_warm_bench_is_offered_a_cooling_a_cold_one_is_not(bench: BenchConfiguration) -> None:
    names = {c: [s.name for s in states(made.COVERED, bench, c)] for c in (22.0, 48.0)}
    assert names[22.0] == ["as found", "warmed up"]
    assert "cooled down" in names[48.0]
    cooled = next(s for s in states(made.COVERED, bench, 48.0) if s.name == "cooled down")
    assert cooled.covered.end > made.COVERED.end + 600.0


def test_named_but_weaker_than_asked_is_a_question(bench: BenchConfiguration) -> None:
    finding, _ = _finding(
        _fast(), status="named", confidence=0.5, alternatives=(made.alternative("friction.stribeck", None),)
    )
    assert questions([finding], 0.2) == ()
    (asked,) = questions([finding], 0.7)
    assert asked.alternatives == ("friction.stribeck",)
    assert "asked for 0.70" in asked.why


def test_what_cannot_be_predicted_is_asked_by_rule_once(bench: BenchConfiguration) -> None:
    finding, data = _finding(made.campaign(), "unknown")
    asked = questions([finding], 0.7)
    covered = extended_range(Range.of(data), bench)
    assert best(asked, covered, data.ratio, bench, CELSIUS, 8.0)[0] is None
    ruled = by_rules(asked, covered, bench, CELSIUS, 8.0, set())
    assert ruled is not None
    assert ruled.gains[0][1] is None
    assert by_rules(asked, covered, bench, CELSIUS, 8.0, {(*asked[0].key, ruled.why)}) is None


def test_what_the_bench_would_need_is_a_refusal_that_would_tell(bench: BenchConfiguration) -> None:
    finding, data = _finding(_fast())
    covered = Range.of(data)
    fastest = covered.fastest * bench.gearbox.ratio
    slow = bench.model_copy(update={"limits": bench.limits.model_copy(update={"motor_speed": 1.1 * fastest})})
    needs = bench_needs(questions([finding], 0.7), covered, data.ratio, slow, CELSIUS)
    assert any("limits.motor_speed" in words for words in needs)


def test_what_came_is_the_change_of_the_loss_of_the_explanation_that_fell() -> None:
    finding, _ = _finding(_fast())
    (asked,) = questions([finding], 0.7)
    after, _ = _finding(
        _fast(), status="named", alternatives=(replace(made.alternative("friction.stribeck", None), loss=25.0),)
    )
    result = outcome_of(asked, [after])
    assert result.gain == pytest.approx(20.0)  # the alternative lost 5 before
    assert result.words == "friction.viscous_quadratic named"
    gone = outcome_of(asked, [])
    assert gone.gain is None
    assert "no such finding" in gone.words
