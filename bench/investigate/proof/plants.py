"""Plants of the examiner whose first campaign leaves open what is concealed, and that go on with any experiment."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from bench.campaigns import load_campaign, make_plan
from bench.campaigns.planning.plan import PlannedTask
from bench.configuration import BenchConfiguration, load_bench
from bench.mismatch.report.candidates import Candidate
from bench.proof.make import load_examiner, write_generated

GROUP = "ambiguous"
BENCH = "rh380n"
"""the bench file that plans the experiments; the generator's benches are of its make"""
_END_OF_COOLING_S = 60.0
"""of a cooling, what is recorded"""
SECONDS_AN_HOUR = 3600.0


def cases(seed: int) -> list[Any]:
    """One case each of what a campaign may lack: staircase, second speed, direction, warm-up, torques."""
    return list(load_examiner().cases(GROUP, seed, None, False))


class HiddenBench:
    """One concealed bench (a :class:`bench.investigate.loop.Lab`): its history goes on from campaign to campaign."""

    def __init__(self, case: Any) -> None:
        self._folder = load_examiner().open_folder(case)
        self._made = 0
        self._last = 0.0
        self.first = tuple(self._folder.campaign.points)

    @property
    def bench(self) -> BenchConfiguration:
        """The file that says what it can do."""
        return load_bench(BENCH).configuration

    def celsius(self, last: float) -> float:
        """It goes on at once."""
        self._last = last
        return last

    def begin(self, folder: Path) -> dict[str, Any]:
        """Make the first campaign; what is concealed."""
        self._write(folder)
        truth: dict[str, Any] = self._folder.truth().to_dict()
        return truth

    def run(self, campaign: Path, folder: Path, after: datetime) -> float:
        """Run a campaign; hours of bench time. The generator's clock goes on by itself, later than ``after``."""
        tasks = make_plan(load_campaign(campaign), self.bench, self._last).tasks
        points = [point for task in tasks for point in self._points(task)]
        history = self._folder.campaign
        # the same history once more, with the new points behind it: what was recorded comes out the same
        self._folder = replace(self._folder, campaign=replace(history, points=(*history.points, *points)))
        return self._write(folder)

    def _points(self, task: PlannedTask) -> Iterator[Any]:
        """A planned task as the generator's points."""
        point, kind = task.point, task.point.sequence
        make = type(self.first[0])
        aim = float(round(task.start_temperature))
        if kind == "heating":
            rate = self.bench.heating.motor_speed / self.bench.gearbox.ratio
            yield make(kind, 0.0, rate, aim, span=task.duration_s)
        elif kind == "cooling":
            yield make("pause", 0.0, 0.0, aim, pause=max(task.duration_s - _END_OF_COOLING_S, 0.0))
            yield make(kind, 0.0, 0.0, aim, span=_END_OF_COOLING_S)
        elif kind == "dwell":
            yield make(kind, point.load_torque, 0.0, aim, span=task.duration_s)
        elif kind == "reversal":
            yield make(kind, point.load_torque, point.velocity, aim, span=float(dict(point.options)["amplitude"]))
        elif kind != "tare":
            yield make(kind, point.load_torque, point.velocity, aim)

    def _write(self, folder: Path) -> float:
        """Write what is new; hours from the end of what was there."""
        folder.mkdir(parents=True, exist_ok=True)
        ended: datetime | None = None
        since: datetime | None = None
        for number, made in enumerate(self._folder.recordings()):
            if number < self._made:
                since = made.started_at
                continue
            since = since or made.started_at
            write_generated(folder, folder.name, made)
            ended = made.started_at
            last_s = made.channels["time"].raw[-1]
            self._made = number + 1
        if ended is None or since is None:
            return 0.0
        return ((ended - since).total_seconds() + float(last_s)) / SECONDS_AN_HOUR

    def grid(self) -> list[Candidate]:
        """The points at constant velocity of the first campaign, in their order."""
        kinds = ("constant_velocity", "validation")
        return [Candidate("constant_velocity", p.torque, p.rate) for p in self.first if p.kind in kinds]
