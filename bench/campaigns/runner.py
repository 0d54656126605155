"""Run a campaign on a rig: point after point into recordings, heating in between, until done, stopped or tripped."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import bench
from bench.campaigns.definition import Campaign
from bench.campaigns.facts import facts
from bench.campaigns.gate import judge
from bench.campaigns.journal import Journal
from bench.campaigns.listener import Listener
from bench.campaigns.plan import Plan
from bench.campaigns.recorder import Recorder
from bench.campaigns.registry import build_sequence
from bench.campaigns.schedule import Task, schedule
from bench.campaigns.taken import Status, Summary, Taken, commanded_velocity, point_id, setpoint_dict
from bench.campaigns.tare import TARE, TareSink
from bench.configuration import BenchFile
from bench.cycle.rig import End, EndKind, Rig
from bench.errors import LimitError
from bench.protocols import Point
from bench.recording import Gearbox, RecordingHeader, Setpoint
from bench.recording.manifest import write_manifest

MOST_TAKES = 3
"""A poor recording is repeated until there are this many takes in one run; all are kept."""


class Runner:
    """One run of a campaign into a folder; goes on where an earlier run of the same campaign ended.

    Parameters
    ----------
    rig : an open bench.
    file, campaign, plan : what is run and what was promised.
    folder : where recordings, journal and ``campaign.json`` go.
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
        self._closing: list[Future[Taken]] = []

    def run(self) -> Summary:
        """Run everything that is missing; the bench is at rest afterwards.

        Raises
        ------
        ConfigurationError
            If the folder holds another campaign.
        LimitError
            If the disk has not enough room left for another point.
        DeviceError
            If a drive does not follow.
        """
        rig, summary = self._rig, self._summary
        start = rig.elapsed_s
        with (
            Journal(self._folder, self._campaign, self._file) as self._journal,
            ThreadPoolExecutor(1, "recording-closer") as self._pool,
        ):
            self._campaign_id = self._journal.remember("id", f"{self._campaign.name}-{rig.now:%Y%m%dT%H%M%S}")
            self._created = self._journal.remember("created_at", datetime.now(UTC).isoformat())
            # points drawn between the start and the highest temperature must stay the same when a run goes on
            start_temperature = float(self._journal.remember("start_temperature", repr(rig.temperature)))
            self._stages = self._campaign.points(start_temperature)
            done = self._journal.done()
            identities = [self._identity(point) for points in self._stages for point in points]
            summary.earlier = sum(identity in done for identity in identities)
            try:
                if summary.earlier < len(identities):
                    self._measure(done)
            finally:
                self._collect(wait=True)
                summary.bench_time_s = rig.elapsed_s - start
                summary.cycles = round(summary.bench_time_s / self._file.configuration.bus.cycle_time)
                self._write_manifest()
        return summary

    def _measure(self, done: set[str]) -> None:
        rig, summary = self._rig, self._summary
        rig.enable()
        zero = self._measure_zero()
        if summary.end.kind is not EndKind.FINISHED:
            return
        rig.tare(zero)
        for stage, points in zip(self._campaign.stages, self._stages, strict=True):
            missing = [point for point in points if self._identity(point) not in done]
            band = self._file.configuration.heating.band
            for task in schedule(missing, stage.order, band, lambda: rig.temperature):
                summary.end = self._task(task)
                if summary.end.kind in (EndKind.TRIPPED, EndKind.INTERRUPTED):
                    return
        summary.tare_drift = self._measure_zero()

    def _measure_zero(self) -> float:
        sink = TareSink(self._rig.scaling)
        phases = build_sequence(TARE.sequence).phases(TARE, facts(self._file.configuration))
        end = self._rig.run(phases, sink, self._stop_requested)
        self._summary.end = end
        return sink.zero if end.kind is EndKind.FINISHED else math.nan

    def _task(self, task: Task) -> End:
        end = End(EndKind.FINISHED)
        for _ in range(MOST_TAKES):
            self._check_disk()
            end, passed = self._record(task)
            if passed or end.kind in (EndKind.TRIPPED, EndKind.INTERRUPTED) or task.is_preparation:
                break
        return end

    def _check_disk(self) -> None:
        free, needed = shutil.disk_usage(self._folder).free, self._file.configuration.storage.minimum_free
        if free < needed:
            raise LimitError(
                f"{self._folder} has {free / 1e6:.0f} MB of disk left, storage.minimum_free = {needed / 1e6:.0f} MB;"
                " make room and run again, finished points are not repeated"
            )

    def _record(self, task: Task) -> tuple[End, bool]:
        point, rig, config = task.point, self._rig, self._file.configuration
        sequence = build_sequence(point.sequence, point.options)
        phases = sequence.phases(point, facts(config))
        identity = self._identity(point)
        take = self._journal.next_take(identity)
        name = self._name(task, identity, sequence.kind, take)
        setpoint = {**setpoint_dict(point), "velocity": commanded_velocity(point, phases)}
        begun = Taken(name, f"{name}.h5", sequence.kind, point.label, setpoint, identity, take, Status.PENDING)
        self._journal.begin(begun)
        header = self._header(begun)
        recorder = Recorder(
            self._folder / begun.file, header, rig.scaling, fast=not rig.is_real_time, ratio=config.gearbox.ratio
        )
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
        taken = replace(
            begun,
            status=Status.DONE if passed else Status.FAILED,
            note=end.text or gate.failures,
            quality=gate.as_dict(),
            duration_s=rig.elapsed_s - start,
            samples=recorder.rows_taken,
        )
        self._close(recorder, taken, complete)
        return end, passed

    def _close(self, recorder: Recorder, taken: Taken, complete: bool) -> None:
        def close() -> Taken:
            recorder.close(complete=complete, accepted=taken.status is Status.DONE, quality=taken.quality)
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
            self._journal.end(taken)
            self._summary.taken.append(taken)
            self._listener.finished(taken)

    def _identity(self, point: Point) -> str:
        return point_id(point, self._file.digest)

    def _name(self, task: Task, identity: str, kind: str, take: int) -> str:
        if task.is_preparation:
            return f"heating-{identity[:6]}-{take:02d}"
        number = next(
            number
            for number, point in enumerate((p for points in self._stages for p in points), 1)
            if self._identity(point) == identity
        )
        again = f"-take{take}" if take > 1 else ""
        return f"{number:04d}-{kind}{again}"

    def _header(self, begun: Taken) -> RecordingHeader:
        config, rig = self._file.configuration, self._rig
        gearbox = config.gearbox
        teeth = gearbox.teeth.model_dump() if gearbox.teeth is not None else {}
        return RecordingHeader(
            recording_id=begun.recording_id,
            campaign_id=self._campaign_id,
            kind=begun.kind,
            started_at=rig.now,
            sample_rate=1.0 / config.bus.cycle_time,
            source=rig.source,
            setpoint=Setpoint(*(math.nan if value is None else value for value in begun.setpoint.values())),
            gearbox=Gearbox(gearbox.ratio, **teeth),
            point_id=begun.point_id,
            take=begun.take,
            zero_id=config.zero_id,
            gearbox_serial=gearbox.serial,
            config=self._file.text,
            software={"name": "gearbench", "version": bench.__version__, "revision": revision()},
            attributes={"tare_torque": rig.zeros.load_torque, "label": begun.label},
        )

    def _write_manifest(self) -> None:
        done = self._journal.done()
        entries = [taken.as_dict() for taken in self._journal.takes()]
        entries += [
            {
                "recording_id": None,
                "file": None,
                "kind": build_sequence(point.sequence, point.options).kind,
                "label": point.label,
                "setpoint": setpoint_dict(point),
                "status": Status.PENDING.value,
                "quality": {},
                "point_id": self._identity(point),
            }
            for points in self._stages
            for point in points
            if self._identity(point) not in done
        ]
        drift = self._summary.tare_drift
        write_manifest(
            self._folder,
            {
                "campaign_id": self._campaign_id,
                "created_at": self._created,
                "bench": self._file.configuration.name,
                "plan": self._plan.as_dict(),
                "campaign_text": self._campaign.text,
                "end": {"kind": self._summary.end.kind.name.lower(), "text": self._summary.end.text},
                "torque_sensor": {
                    "tare_before_nm": self._rig.zeros.load_torque,
                    "drift_nm": None if math.isnan(drift) else drift,
                },
                "recordings": entries,
            },
        )


@cache
def revision() -> str:
    """Return the revision of the program where it runs from a git work tree, else an empty text."""
    head = Path(bench.__file__).resolve().parent.parent / ".git" / "HEAD"
    try:
        text = head.read_text("utf-8").strip()
        return (head.parent / text.removeprefix("ref: ")).read_text("utf-8").strip() if "ref:" in text else text
    except OSError:
        return ""
