"""What a run says of itself: its plan, its points, where it stands, in messages a page can show."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any

from bench.campaigns.listener import Expected
from bench.campaigns.planning.facts import facts
from bench.campaigns.planning.outlook import costs, expected_way, planned_way
from bench.campaigns.planning.plan import Plan
from bench.campaigns.planning.registry import build_sequence
from bench.campaigns.planning.schedule import Task
from bench.campaigns.taken import Taken
from bench.configuration import BenchConfiguration
from bench.protocols import Point

Message = dict[str, Any]
_STATUS_EVERY_S = 0.25


class Reporter:
    """A listener of the run that keeps its state and sends each change.

    Attributes
    ----------
    phase : ``opening``, ``measuring_zero``, ``measuring``, ``heating``, ``paused``, ``stopping`` or ``ended``.
    """

    def __init__(self, bench: BenchConfiguration, emit: Callable[[Message], None]) -> None:
        self._bench, self._emit = bench, emit
        self._lock = threading.Lock()
        self._plan: Message | None = None
        self._cost: dict[Point, float] = {}
        self._numbers: dict[Point, Expected] = {}
        self._points: dict[str, Message] = {}
        self._before_pause = "opening"
        self._task: Task | None = None
        self._task_began_s = self._bench_s = self._closing_s = 0.0
        self._started = datetime.now(UTC)
        """When bench time was zero; known from the first motion on."""
        self._motion: datetime | None = None
        self._last_status_s = 0.0
        self._status: Message = {"type": "status", "phase": "opening", "label": "the bench is being opened"}

    def greeting(self) -> list[Message]:
        """What someone who listens from now on has to know first."""
        with self._lock:
            plan = [] if self._plan is None else [{**self._plan, "points": list(self._points.values())}]
            return [*plan, dict(self._status)]

    def report_status(self, phase: str, label: str = "", **more: Any) -> None:
        """Say where the run stands."""
        with self._lock:
            self._status = {**self._status, "phase": phase, "label": label, **more}
            message = dict(self._status)
        self._emit(message)

    def points(self) -> dict[str, Message]:
        """The points of the run by identity, as they stand."""
        with self._lock:
            return dict(self._points)

    def asked(self, wish: str, identity: str) -> None:
        """Tell at once what the operator asked for a point that does not run: it is left out, or measured once more."""
        now = self._points.get(identity, {}).get("state")
        if wish == "skip" and now == "waiting":
            self._change(identity, state="skipped", note="left out by the operator")
        elif wish == "repeat" and now in ("done", "failed", "skipped"):
            self._change(identity, state="waiting", note="once more")

    def motion(self, bench_time: datetime) -> None:
        """A motion begins at this time of day on the bench; the first one is the beginning of the plan."""
        self._motion = bench_time
        with self._lock:
            if self._plan is None or "began" in self._plan:
                return
            self._plan["began"] = bench_time.timestamp()
            message = {**self._plan, "points": list(self._points.values())}
        self._emit(message)

    # -- the listener --------------------------------------------------------------------------------------------------

    def planned(self, campaign_id: str, plan: Plan, points: Sequence[Expected]) -> None:
        """Tell the whole plan; the torque sensor's zero is measured first."""
        with self._lock:
            self._cost = costs(plan)
            # the zero is measured again after the last point
            self._closing_s = plan.duration_s - sum(self._cost.values())
            self._numbers = {expected.point: expected for expected in points}
            self._points = {expected.identity: self._point(expected) for expected in points}
            self._plan = {
                "type": "plan",
                "campaign_id": campaign_id,
                "campaign": plan.campaign,
                "duration_s": plan.duration_s,
                "energy_j": plan.energy_j,
                "way": planned_way(plan),
            }
            message = {**self._plan, "points": list(self._points.values())}
        self._emit(message)
        self.report_status("measuring_zero", "zero of the torque sensor", remaining_s=self._remaining())

    def started(self, task: Task, recording_id: str) -> None:
        """Tell of a recording that begins, and where the lubricant is expected to go in a heating."""
        for earlier in [key for key, point in self._points.items() if point["state"] in ("running", "heating")]:
            self._change(earlier, state="saving")
        self._task, self._task_began_s = task, self._bench_s
        heating = task.is_preparation
        target = task.point.temperature
        label = task.point.label
        if heating and target is not None:
            label = f"warming the lubricant to {target:.1f} °C"
        expected = self._numbers.get(task.prepares or task.point)
        identity = None if expected is None else expected.identity
        if identity is not None:
            self._change(identity, state="heating" if heating else "running")
        self.report_status(
            "heating" if heating else "measuring",
            label,
            recording_id=recording_id,
            identity=identity,
            target=target,
            way=None,
            remaining_s=self._remaining(),
        )

    def advanced(self, bench_time_s: float, temperature: float) -> None:
        """Tell time and temperature now and then."""
        self._bench_s = bench_time_s
        if self._motion is not None:
            # asked after the first block of a motion: right to that block
            self._started, self._motion = self._motion - timedelta(seconds=bench_time_s), None
        task, now = self._task, time.monotonic()
        if now - self._last_status_s < _STATUS_EVERY_S or task is None:
            return
        self._last_status_s = now
        more: Message = {}
        if self._status.get("way") is None and self._status["phase"] == "heating":
            more["way"] = self._expected_temperatures(task, temperature)
        moment = self._started + timedelta(seconds=bench_time_s)
        self.report_status(
            self._status["phase"],
            self._status["label"],
            bench_time=moment.timestamp(),
            elapsed_s=bench_time_s,
            temperature=temperature,
            remaining_s=self._remaining(),
            **more,
        )

    def finished(self, taken: Taken) -> None:
        """Tell what became of a recording."""
        if taken.point_id not in self._points:
            return
        self._change(
            taken.point_id,
            state=taken.status.value,
            complete=taken.complete,
            take=taken.take,
            note=taken.note,
            file=taken.file,
            quality=taken.quality,
        )

    def pausing(self, asked: bool) -> None:
        """Tell that a pause was asked for, which comes with the end of the point, or that it was taken back."""
        self.report_status(self._status["phase"], self._status["label"], pausing=asked)

    def paused(self, now: bool, why: str = "") -> None:
        """Tell of a pause, now and then as long as it lasts, and of its end."""
        if now:
            self._before_pause = self._before_pause if self._status["phase"] == "paused" else self._status["phase"]
            self.report_status("paused", why or "waiting for the operator between two points", pausing=False)
        elif self._status["phase"] == "paused":
            self.report_status(self._before_pause)

    def noticed(self, text: str) -> None:
        """Tell what of the bench is not as it should be."""
        self._emit({"type": "notice", "text": text})

    # -- private -------------------------------------------------------------------------------------------------------

    def _point(self, expected: Expected) -> Message:
        point = expected.point
        return {
            "number": expected.number,
            "identity": expected.identity,
            "label": point.label,
            "sequence": point.sequence,
            "stage": point.stage,
            "load_torque": point.load_torque,
            "velocity": point.velocity,
            "temperature": point.temperature,
            "repeat": point.repeat,
            "state": "done" if expected.done else "waiting",
            "duration_s": self._cost.get(point, 0.0),
        }

    def _change(self, identity: str, **more: Any) -> None:
        with self._lock:
            self._points[identity] = {**self._points[identity], **more}
            message = {"type": "point", **self._points[identity]}
        self._emit(message)

    def _remaining(self) -> float:
        """Planned bench time of all points still to come and of the closing zero, and of the rest of what runs."""
        with self._lock:
            open_points = [
                point for point in self._points.values() if point["state"] in ("waiting", "running", "heating")
            ]
            total: float = sum(point["duration_s"] for point in open_points)
            runs = any(point["state"] != "waiting" for point in open_points)
        if not runs or self._task is None:
            return total + self._closing_s
        cost = self._cost.get(self._task.prepares or self._task.point, 0.0)
        return total + self._closing_s - min(self._bench_s - self._task_began_s, cost)

    def _expected_temperatures(self, task: Task, temperature: float) -> list[list[float]]:
        """The lubricant's expected way in this heating: bench time of day (Unix, s) and °C."""
        point = task.point
        phases = build_sequence(point.sequence, point.options).phases(point, facts(self._bench))
        way, _ = expected_way(phases, self._bench, temperature)
        start = self._started.timestamp() + self._bench_s
        step = max(1, len(way) // 200)
        return [[start + seconds, degrees] for seconds, degrees in [*way[::step], way[-1]]]
