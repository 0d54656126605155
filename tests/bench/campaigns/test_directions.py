"""What an operator asks of a run on its way: pause, skip, repeat, a note; and what a tap sees of it."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Sequence
from datetime import datetime
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.campaigns import Block, Campaign, Plan, Stage
from bench.campaigns.execution.session import run_campaign
from bench.campaigns.listener import Expected, Silent
from bench.campaigns.operator.directions import Directions
from bench.campaigns.planning.schedule import Task
from bench.campaigns.taken import Status, Summary, Taken
from bench.configuration import load_bench
from bench.cycle.channels import Scaling
from bench.cycle.end import EndKind
from bench.protocols import Segment
from bench.recording import Recording, RecordingFolder
from bench.service.data.recordings import folders

SPEEDS = tuple(radians(speed) for speed in (60, -60, 50))
CAMPAIGN = Campaign("short", "three fast points", (Stage("all", (Block("constant_velocity", (0.0,), SPEEDS),)),))


class Operator(Silent):
    """Acts when the n-th recording begins, and remembers what it was told."""

    def __init__(self, act: Callable[[Operator], None], at: int = 1) -> None:
        self.directions = Directions()
        self.points: Sequence[Expected] = ()
        self.begun: list[str] = []
        self.ended: list[Taken] = []
        self.pauses: list[bool] = []
        self._act, self._at = act, at

    def planned(self, campaign_id: str, plan: Plan, points: Sequence[Expected]) -> None:
        self.points = points

    def started(self, task: Task, recording_id: str) -> None:
        self.begun.append(recording_id)
        if len(self.begun) == self._at:
            self._act(self)

    def finished(self, taken: Taken) -> None:
        self.ended.append(taken)

    def paused(self, now: bool, why: str = "") -> None:
        self.pauses.append(now)


def run(operator: Operator, folder: Path, **more: Any) -> Summary:
    return run_campaign(load_bench("rh380n"), CAMPAIGN, folder, operator, directions=operator.directions, **more)


def test_the_point_that_runs_is_skipped_and_the_next_one_measured(tmp_path: Path) -> None:
    operator = Operator(lambda o: o.directions.skip(o.points[0].identity))
    summary = run(operator, tmp_path)
    assert summary.end.kind is EndKind.FINISHED
    assert [taken.status for taken in operator.ended] == [Status.SKIPPED, Status.DONE, Status.DONE]
    assert [taken.complete for taken in operator.ended] == [False, True, True]
    assert not summary.failed
    cut = Recording.open(tmp_path / operator.ended[0].file)
    assert not cut.complete
    # another run measures what was left out
    again = run(Operator(lambda _: None), tmp_path)
    assert again.earlier == 2
    assert [taken.status for taken in again.taken] == [Status.DONE]


def test_a_point_that_is_stopped_is_told_as_not_complete(tmp_path: Path) -> None:
    run(Operator(lambda o: o.directions.stop()), tmp_path / "spring")
    (last,) = json.loads((tmp_path / "spring" / "campaign.json").read_text("utf-8"))["recordings"][:1]
    assert (last["status"], last["complete"]) == ("failed", False)
    (entry,) = folders(tmp_path)
    assert (entry["done"], entry["failed"], entry["cut_short"]) == (0, 0, 1)


def test_a_point_still_to_come_is_left_out(tmp_path: Path) -> None:
    operator = Operator(lambda o: o.directions.skip(o.points[2].identity))
    run(operator, tmp_path)
    assert [taken.point_id for taken in operator.ended] == [point.identity for point in operator.points[:2]]


def test_a_point_is_measured_once_more_and_both_takes_are_kept(tmp_path: Path) -> None:
    operator = Operator(lambda o: o.directions.repeat(o.points[0].identity), at=2)
    run(operator, tmp_path)
    first = operator.points[0].identity
    assert [taken.take for taken in operator.ended if taken.point_id == first] == [1, 2]
    assert len(RecordingFolder.open(tmp_path).recordings) == 4


def test_a_pause_holds_the_next_point_until_the_operator_goes_on(tmp_path: Path) -> None:
    class Patient(Operator):
        def paused(self, now: bool, why: str = "") -> None:
            super().paused(now, why)
            # it says so as long as it lasts: a run that is silent is taken for one that hangs
            if self.pauses == [True, True]:
                self.directions.go_on()

    operator = Patient(lambda o: o.directions.pause())
    summary = run(operator, tmp_path)
    assert operator.pauses == [True, True, False]
    assert len(summary.taken) == 3


def test_a_stop_ends_a_pause(tmp_path: Path) -> None:
    def pause(operator: Operator) -> None:
        operator.directions.pause()
        threading.Timer(0.3, operator.directions.stop).start()

    operator = Operator(pause)
    summary = run(operator, tmp_path)
    assert summary.end.kind is EndKind.INTERRUPTED
    assert len(operator.begun) <= 2


def test_a_note_stands_in_the_recording(tmp_path: Path) -> None:
    operator = Operator(lambda o: o.directions.note("the window was open"), at=2)
    run(operator, tmp_path)
    events = [
        (recording.recording_id, event.text)
        for recording in RecordingFolder.open(tmp_path).recordings
        for event in recording.events
        if event.level == "note"
    ]
    assert events == [(operator.begun[1], "the window was open")]


class Watching:
    def __init__(self) -> None:
        self.motions: list[str] = []
        self.rows_seen: dict[str, int] = {}
        self.segments: set[Segment | None] = set()
        self.scaling: Scaling | None = None

    def opened(self, view: object) -> None:
        assert view is not None

    def begin(self, scaling: Scaling, bench_time: datetime, what: str) -> None:
        assert bench_time.utcoffset() is not None
        self.motions.append(what)
        self.scaling = scaling

    def segment(self, segment: Segment | None) -> None:
        self.segments.add(segment)

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        size = int(raw["cycle"].size)
        self.rows_seen[self.motions[-1]] = self.rows_seen.get(self.motions[-1], 0) + size
        assert all(np.asarray(values).size == size for values in raw.values())


def test_a_tap_sees_the_very_rows_that_are_recorded(tmp_path: Path) -> None:
    tap = Watching()
    summary = run(Operator(lambda _: None), tmp_path, tap=tap)
    assert tap.motions == ["tare", *["constant_velocity"] * 3, "tare"]
    assert tap.rows_seen["constant_velocity"] == sum(taken.samples for taken in summary.taken)
    assert Segment.STEADY in tap.segments
    assert tap.scaling is not None
    assert tap.scaling.scale("motor_angle") == pytest.approx(2 * np.pi / 8192)
