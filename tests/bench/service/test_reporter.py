"""What a run says of itself: its plan, points as they change, the time left, the way of a heating."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from bench.campaigns import Plan, load_campaign, make_plan
from bench.campaigns.listener import Expected
from bench.campaigns.planning.schedule import Task
from bench.campaigns.taken import Status, Taken
from bench.configuration import load_bench
from bench.protocols import Point
from bench.service.process.reporter import Reporter

BENCH = load_bench("rh380n").configuration
CLOSING_S = make_plan(load_campaign("quick"), BENCH).tasks[-1].duration_s
"""The torque sensor's zero is measured again after the last point."""
BEGAN = datetime(2026, 11, 21, 6, 0, tzinfo=UTC)


class Recorder:
    def __init__(self) -> None:
        self.messages: list[dict[str, Any]] = []
        self.reporter = Reporter(BENCH, self.messages.append)

    def last(self, kind: str) -> dict[str, Any]:
        return next(message for message in reversed(self.messages) if message["type"] == kind)


@pytest.fixture
def plan() -> Plan:
    return make_plan(load_campaign("quick"), BENCH)


@pytest.fixture
def recorder(plan: Plan) -> Recorder:
    said = Recorder()
    points = [task.point for task in plan.tasks if not task.is_preparation]
    expected = [Expected(number, f"{number:016x}", point, number == 1) for number, point in enumerate(points, 1)]
    said.reporter.planned("quick-1", plan, expected)
    return said


def left(points: list[dict[str, Any]]) -> float:
    return CLOSING_S + sum(point["duration_s"] for point in points)


def first(plan: Plan, number: int) -> Point:
    return [task.point for task in plan.tasks if not task.is_preparation][number - 1]


def taken(identity: str, status: Status) -> Taken:
    return Taken("0002-x", "0002-x.h5", "constant_velocity", "", {}, identity, 1, status)


def test_the_plan_begins_with_the_first_motion_whenever_the_bench_was_opened(recorder: Recorder) -> None:
    assert "began" not in recorder.last("plan")
    recorder.reporter.motion(BEGAN)
    recorder.reporter.motion(BEGAN + timedelta(hours=1))
    assert recorder.last("plan")["began"] == BEGAN.timestamp()
    greeting = recorder.reporter.greeting()
    assert [message["type"] for message in greeting] == ["plan", "status"]
    assert [point["state"] for point in greeting[0]["points"]] == ["done", *["waiting"] * 4]


def test_what_is_left_is_what_the_points_still_to_come_are_planned_to_take(recorder: Recorder, plan: Plan) -> None:
    points = recorder.last("plan")["points"]
    assert recorder.last("status")["remaining_s"] == pytest.approx(
        CLOSING_S + sum(point["duration_s"] for point in points[1:])
    )
    recorder.reporter.started(Task(first(plan, 2)), "0002-x")
    assert recorder.last("status")["phase"] == "measuring"
    assert recorder.last("point")["state"] == "running"
    recorder.reporter.started(Task(first(plan, 3)), "0003-x")
    states = [point["state"] for point in recorder.reporter.greeting()[0]["points"]]
    assert states == ["done", "saving", "running", "waiting", "waiting"]
    recorder.reporter.finished(taken(f"{2:016x}", Status.DONE))
    assert recorder.last("point")["state"] == "done"
    assert recorder.last("status")["remaining_s"] == pytest.approx(
        CLOSING_S + sum(point["duration_s"] for point in points[2:])
    )


def test_a_point_that_was_stopped_says_that_it_is_not_complete(recorder: Recorder) -> None:
    for complete in (False, True, None):
        recorder.reporter.finished(replace(taken(f"{2:016x}", Status.FAILED), complete=complete))
        assert (recorder.last("point")["state"], recorder.last("point")["complete"]) == ("failed", complete)


def test_a_pause_that_was_asked_for_is_shown_before_it_comes(recorder: Recorder, plan: Plan) -> None:
    recorder.reporter.started(Task(first(plan, 2)), "0002-x")
    recorder.reporter.pausing(True)
    assert (recorder.last("status")["phase"], recorder.last("status")["pausing"]) == ("measuring", True)
    recorder.reporter.paused(True)
    assert (recorder.last("status")["phase"], recorder.last("status")["pausing"]) == ("paused", False)
    # said again as long as it lasts; what went before is not forgotten
    recorder.reporter.paused(True)
    recorder.reporter.paused(False)
    assert recorder.last("status")["phase"] == "measuring"


def test_what_the_operator_asks_of_a_point_is_shown_at_once(recorder: Recorder, plan: Plan) -> None:
    last = f"{5:016x}"
    recorder.reporter.asked("skip", last)
    assert recorder.last("point")["state"] == "skipped"
    recorder.reporter.asked("repeat", last)
    assert recorder.last("point")["state"] == "waiting"
    recorder.reporter.started(Task(first(plan, 2)), "0002-x")
    before = len(recorder.messages)
    # the one that runs says itself what becomes of it
    recorder.reporter.asked("skip", f"{2:016x}")
    assert len(recorder.messages) == before


def test_a_heating_shows_the_way_the_lubricant_is_expected_to_go(recorder: Recorder, plan: Plan) -> None:
    recorder.reporter.motion(BEGAN)
    heating = Task(Point("heating", temperature=30.0), is_preparation=True, prepares=first(plan, 2))
    recorder.reporter.started(heating, "heating-x")
    assert recorder.last("status")["phase"] == "heating"
    assert recorder.last("point")["state"] == "heating"
    recorder.reporter.advanced(0.5, 25.0)
    status = recorder.last("status")
    assert status["target"] == 30.0
    assert status["way"][0] == [pytest.approx(BEGAN.timestamp()), 25.0]
    assert max(degrees for _, degrees in status["way"]) == pytest.approx(30.0 + BENCH.heating.hysteresis, abs=0.05)
    assert status["bench_time"] == pytest.approx(BEGAN.timestamp())


def test_a_pause_ends_where_it_began(recorder: Recorder, plan: Plan) -> None:
    recorder.reporter.started(Task(first(plan, 2)), "0002-x")
    recorder.reporter.paused(True)
    assert recorder.last("status")["phase"] == "paused"
    recorder.reporter.paused(False)
    assert recorder.last("status")["phase"] == "measuring"
