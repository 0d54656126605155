"""Run a campaign on a rig: point after point into recordings, heating in between, until done, stopped or tripped."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from datetime import UTC, datetime
from enum import Enum
from hashlib import sha256
from pathlib import Path
from typing import Any, Protocol

import bench
from bench.campaigns.definition import Campaign
from bench.campaigns.facts import facts
from bench.campaigns.gate import Gate, judge
from bench.campaigns.plan import Plan
from bench.campaigns.recorder import Recorder
from bench.campaigns.registry import build_sequence
from bench.campaigns.schedule import HEATING, Task, schedule
from bench.configuration import BenchFile
from bench.cycle.rig import End, EndKind, Rig
from bench.errors import ConfigurationError
from bench.protocols import Point
from bench.recording import Gearbox, RecordingHeader, Setpoint
from bench.recording.manifest import write_manifest

MOST_TAKES = 3
"""A poor recording is repeated until there are this many takes; all are kept."""


class Status(Enum):
    """What became of a point."""

    DONE = "done"
    FAILED = "failed"
    SKIPPED = "skipped"
    PENDING = "pending"


@dataclass(frozen=True, slots=True)
class Taken:
    """One recording that was made."""

    recording_id: str
    file: str
    kind: str
    point: Point
    point_id: str
    take: int
    status: Status
    note: str
    quality: dict[str, Any]
    duration_s: float
    samples: int

    def as_dict(self) -> dict[str, Any]:
        """For ``campaign.json``."""
        return {
            "recording_id": self.recording_id,
            "file": self.file,
            "kind": self.kind,
            "setpoint": setpoint_dict(self.point),
            "status": self.status.value,
            "quality": self.quality,
            "point_id": self.point_id,
            "take": self.take,
            "note": self.note,
        }


class Listener(Protocol):
    """Is told how a campaign goes."""

    def started(self, task: Task, recording_id: str) -> None:
        """A recording begins."""
        ...

    def advanced(self, bench_time_s: float, temperature: float) -> None:
        """Bench time went on."""
        ...

    def finished(self, taken: Taken) -> None:
        """A recording is in its file."""
        ...


@dataclass(slots=True)
class Summary:
    """What a campaign brought."""

    end: End = field(default_factory=lambda: End(EndKind.FINISHED))
    taken: list[Taken] = field(default_factory=list)
    bench_time_s: float = 0.0
    cycles: int = 0
    tare_drift: float = math.nan

    @property
    def failed(self) -> list[Taken]:
        """Recordings that did not pass and were not made up for by another take."""
        good = {taken.point_id for taken in self.taken if taken.status is Status.DONE}
        return [taken for taken in self.taken if taken.status is not Status.DONE and taken.point_id not in good]


def point_id(point: Point, bench_digest: str) -> str:
    """Return what a point is, by content: the point itself and the bench configuration it is measured under."""
    content = json.dumps(
        [
            point.sequence,
            point.load_torque,
            point.velocity,
            point.temperature,
            point.repeat,
            point.stage,
            list(point.options),
            bench_digest,
        ]
    )
    return sha256(content.encode()).hexdigest()[:16]


def setpoint_dict(point: Point) -> dict[str, float | None]:
    """Return the set point as the manifest has it."""
    return {"load_torque": point.load_torque, "velocity": point.velocity, "temperature": point.temperature}


class Runner:
    """One run of a campaign into a folder.

    Parameters
    ----------
    rig : an open bench.
    file, campaign, plan : what is run and what was promised.
    folder : where recordings and ``campaign.json`` go.
    listener : is told about progress.
    stop_requested : asked between blocks.
    """

    def __init__(
        self,
        rig: Rig,
        file: BenchFile,
        campaign: Campaign,
        plan: Plan,
        folder: Path,
        listener: Listener,
        stop_requested: Callable[[], bool],
    ) -> None:
        self._rig, self._file, self._campaign, self._plan = rig, file, campaign, plan
        self._folder, self._listener, self._stop_requested = folder, listener, stop_requested
        self._summary = Summary()
        self._campaign_id = f"{campaign.name}-{rig.now:%Y%m%dT%H%M%S}"
        self._created = datetime.now(UTC)
        self._closing: list[Future[Taken]] = []
        self._heatings = 0
        self._number = 0
        self._done: set[Point] = set()

    def run(self) -> Summary:
        """Run everything; the bench is at rest without voltage afterwards."""
        rig, summary = self._rig, self._summary
        self._folder.mkdir(parents=True, exist_ok=True)
        start = rig.elapsed_s
        stages = self._campaign.points(rig.temperature)
        self._all = [point for points in stages for point in points]
        with ThreadPoolExecutor(1, "recording-closer") as self._pool:
            try:
                rig.enable()
                for stage, points in zip(self._campaign.stages, stages, strict=True):
                    band = self._file.configuration.heating.band
                    for task in schedule(points, stage.order, band, lambda: rig.temperature):
                        summary.end = self._task(task)
                        if summary.end.kind in (EndKind.TRIPPED, EndKind.INTERRUPTED):
                            return summary
                rig.shutdown()
                summary.tare_drift = rig.measure_tare()
            finally:
                self._collect(wait=True)
                summary.bench_time_s = rig.elapsed_s - start
                summary.cycles = round(summary.bench_time_s / self._file.configuration.bus.cycle_time)
                self._write_manifest()
        return summary

    def _task(self, task: Task) -> End:
        end = End(EndKind.FINISHED)
        for take in range(1, MOST_TAKES + 1):
            end, passed = self._record(task, take)
            if passed or end.kind in (EndKind.TRIPPED, EndKind.INTERRUPTED) or task.is_preparation:
                break
        if not task.is_preparation:
            self._done.add(task.point)
        return end

    def _record(self, task: Task, take: int) -> tuple[End, bool]:
        point, rig, config = task.point, self._rig, self._file.configuration
        sequence = build_sequence(point.sequence, point.options)
        try:
            phases = sequence.phases(point, facts(config))
        except ValueError as error:
            raise ConfigurationError(f"point {point.label}: {error}") from error
        name = self._name(task, sequence.kind, take)
        identity = point_id(point, self._file.digest)
        header = self._header(name, sequence.kind, point, identity, take)
        path = self._folder / f"{name}.h5"
        recorder = Recorder(path, header, rig.scaling, fast=not rig.is_real_time, ratio=config.gearbox.ratio)
        self._listener.started(task, name)
        start = rig.elapsed_s

        def stop() -> bool:
            self._listener.advanced(rig.elapsed_s, rig.temperature)
            return self._stop_requested()

        end = rig.run(phases, recorder, stop)
        gate = judge(point, sequence.kind, recorder.figures, config)
        complete = end.kind in (EndKind.FINISHED, EndKind.EXPIRED)
        passed = end.kind is EndKind.FINISHED and gate.passed
        if end.kind is EndKind.EXPIRED:
            recorder.event("warning", end.text)
        if complete and not gate.passed:
            recorder.event("warning", f"quality gate: {gate.failures}")
        taken = Taken(
            name,
            path.name,
            sequence.kind,
            point,
            identity,
            take,
            Status.DONE if passed else Status.FAILED,
            end.text or gate.failures,
            gate.as_dict(),
            rig.elapsed_s - start,
            recorder.rows_taken,
        )
        self._close(recorder, taken, gate, complete)
        return end, passed

    def _close(self, recorder: Recorder, taken: Taken, gate: Gate, complete: bool) -> None:
        def close() -> Taken:
            recorder.close(complete=complete, accepted=taken.status is Status.DONE, quality=gate.as_dict())
            return taken

        self._closing.append(self._pool.submit(close))
        while self._rig.is_real_time and not self._closing[-1].done():
            # the bus must not fall silent while a file is finished, or the drives' watchdogs act
            self._rig.idle()
        # at most one file may be on its way to the disk while the next is being made
        self._collect(wait=len(self._closing) > 1)

    def _collect(self, wait: bool) -> None:
        while self._closing and (wait or self._closing[0].done()):
            taken = self._closing.pop(0).result()
            self._summary.taken.append(taken)
            self._listener.finished(taken)

    def _name(self, task: Task, kind: str, take: int) -> str:
        if task.point.sequence == HEATING and task.is_preparation:
            self._heatings += 1
            return f"heating-{self._heatings:03d}"
        if take == 1:
            self._number += 1
        again = f"-take{take}" if take > 1 else ""
        return f"{self._number:04d}-{kind}{again}"

    def _header(self, name: str, kind: str, point: Point, identity: str, take: int) -> RecordingHeader:
        config, rig = self._file.configuration, self._rig
        gearbox = config.gearbox
        teeth = gearbox.teeth.model_dump() if gearbox.teeth is not None else {}
        return RecordingHeader(
            recording_id=name,
            campaign_id=self._campaign_id,
            kind=kind,
            started_at=rig.now,
            sample_rate=1.0 / config.bus.cycle_time,
            source=rig.source,
            setpoint=Setpoint(
                point.load_torque, point.velocity, math.nan if point.temperature is None else point.temperature
            ),
            gearbox=Gearbox(gearbox.ratio, **teeth),
            point_id=identity,
            take=take,
            zero_id=config.zero_id,
            gearbox_serial=gearbox.serial,
            config=self._file.text,
            software={"name": "gearbench", "version": bench.__version__, "revision": revision()},
            attributes={"tare_torque": rig.zeros.load_torque, "label": point.label},
        )

    def _write_manifest(self) -> None:
        entries = [taken.as_dict() for taken in self._summary.taken]
        entries += [
            {
                "recording_id": None,
                "file": None,
                "kind": build_sequence(point.sequence, point.options).kind,
                "setpoint": setpoint_dict(point),
                "status": Status.PENDING.value,
                "quality": {},
                "point_id": point_id(point, self._file.digest),
            }
            for point in self._all
            if point not in self._done
        ]
        write_manifest(
            self._folder,
            {
                "campaign_id": self._campaign_id,
                "created_at": self._created.isoformat(),
                "bench": self._file.configuration.name,
                "plan": self._plan.as_dict(),
                "campaign_text": self._campaign.text,
                "end": {"kind": self._summary.end.kind.name.lower(), "text": self._summary.end.text},
                "torque_sensor": {
                    "tare_before_nm": self._rig.zeros.load_torque,
                    "drift_nm": None if math.isnan(self._summary.tare_drift) else self._summary.tare_drift,
                },
                "recordings": entries,
            },
        )


def revision() -> str:
    """Return the revision of the program where it runs from a git work tree, else an empty text."""
    head = Path(bench.__file__).resolve().parent.parent / ".git" / "HEAD"
    try:
        text = head.read_text("utf-8").strip()
        return (head.parent / text.removeprefix("ref: ")).read_text("utf-8").strip() if "ref:" in text else text
    except OSError:
        return ""
