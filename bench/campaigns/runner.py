"""Run a campaign on a rig: point after point into recordings, heating in between, until done, stopped or tripped."""

from __future__ import annotations

import math
import shutil
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from bench.campaigns.definition import Campaign
from bench.campaigns.directions import Directions
from bench.campaigns.facts import facts
from bench.campaigns.gate import judge
from bench.campaigns.journal import Journal
from bench.campaigns.listener import Expected, Listener, Tap, Tapped
from bench.campaigns.manifest import end_and_zero, recordings
from bench.campaigns.plan import Plan
from bench.campaigns.provenance import recording_header
from bench.campaigns.recorder import Recorder
from bench.campaigns.registry import build_sequence
from bench.campaigns.schedule import Task, schedule
from bench.campaigns.stop_log import StopLog
from bench.campaigns.taken import Status, Summary, Taken, commanded_velocity, point_id, setpoint_dict
from bench.campaigns.tare import TARE, TareSink
from bench.configuration import BenchFile
from bench.cycle.rig import End, EndKind, Rig
from bench.cycle.sink import Sink
from bench.errors import DeviceError, LimitError, RecordingError
from bench.protocols import Point
from bench.recording.manifest import write_manifest

_PAUSE_S = 0.25
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
    directions : what the operator asks of the run on its way; None for one nobody talks to.
    tap : sees the rows of every motion; None for nobody.
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
        directions: Directions | None = None,
        tap: Tap | None = None,
    ) -> None:
        self._rig, self._file, self._campaign, self._plan = rig, file, campaign, plan
        self._folder, self._listener = folder, listener
        self._directions, self._tap = directions or Directions(), tap
        self._interrupted = stop_requested
        self._summary = Summary()
        self._stops = StopLog(folder)
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
            every = enumerate((point for points in self._stages for point in points), 1)
            self._points = [Expected(number, id_ := self._identity(p), p, id_ in done) for number, p in every]
            summary.earlier = sum(expected.done for expected in self._points)
            zero = rig.zero_id or "unnamed"
            first = self._journal.remember("zero", zero)
            if first != zero:
                self._listener.noticed(f"encoder zero {zero}, begun with zero {first}: analyses keep recordings apart")
            self._listener.planned(self._campaign_id, self._plan, self._points)
            try:
                if summary.earlier < len(self._points):
                    self._measure(done)
            finally:
                self._stops.write(rig.stops)
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
            for task in schedule(missing, stage.order, band, lambda: rig.temperature, self._left_out):
                summary.end = self._task(task)
                self._repeat()
                if summary.end.kind in (EndKind.TRIPPED, EndKind.INTERRUPTED):
                    return
        summary.tare_drift = self._measure_zero()

    def _stop_requested(self) -> bool:
        return self._interrupted() or self._directions.stop_requested

    def _left_out(self, point: Point) -> bool:
        """Wait while the operator pauses; then whether this point is to be skipped."""
        self._pause()
        return self._directions.is_skipped(self._identity(point))

    def _pause(self) -> None:
        if not self._directions.paused:
            return
        while self._directions.paused and not self._stop_requested():
            # said again and again: whoever listens takes a run that says nothing for one that hangs
            self._listener.paused(True)
            before = self._rig.elapsed_s
            if self._rig.is_real_time:
                self._rig.idle(_PAUSE_S)
            if self._rig.elapsed_s == before:
                # fast emulation stands still; a bench that tripped does nothing until the next motion says so
                time.sleep(_PAUSE_S)
        self._listener.paused(False)

    def _repeat(self) -> None:
        """Measure once more what the operator asked for."""
        points = {expected.identity: expected.point for expected in self._points}
        while (identity := self._directions.take_repeat()) is not None:
            if self._summary.end.kind in (EndKind.TRIPPED, EndKind.INTERRUPTED):
                return
            if identity in points and not self._left_out(points[identity]):
                self._summary.end = self._task(Task(points[identity]))

    def _watched(self, sink: Sink, what: str) -> Sink:
        if self._tap is None:
            return sink
        self._tap.begin(self._rig.scaling, self._rig.now, what)
        return Tapped(sink, self._tap)

    def _measure_zero(self) -> float:
        sink = TareSink(self._rig.scaling)
        phases = build_sequence(TARE.sequence).phases(TARE, facts(self._file.configuration))
        end = self._rig.run(phases, self._watched(sink, TARE.sequence), self._stop_requested)
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
        header = recording_header(begun, self._campaign_id, self._file, rig)
        recorder = Recorder(
            self._folder / begun.file, header, rig.scaling, fast=not rig.is_real_time, ratio=config.gearbox.ratio
        )
        self._listener.started(task, name)
        start = rig.elapsed_s
        skippable = self._identity(task.prepares or point)

        def stop() -> bool:
            self._listener.advanced(rig.elapsed_s, rig.temperature)
            for note in self._directions.take_notes():
                recorder.event("note", note)
            return self._stop_requested() or self._directions.is_skipped(skippable)

        end = rig.run(phases, self._watched(recorder, sequence.kind), stop)
        self._stops.write(rig.stops, name)
        skipped = end.kind is EndKind.INTERRUPTED and not self._stop_requested()
        gate = judge(point, sequence.kind, recorder.figures, config)
        complete = end.kind in (EndKind.FINISHED, EndKind.EXPIRED)
        passed = end.kind is EndKind.FINISHED and gate.passed
        if end.kind is EndKind.EXPIRED:
            recorder.event("warning", end.text)
        if complete and not gate.passed:
            recorder.event("warning", f"quality gate: {gate.failures}")
        taken = replace(
            begun,
            status=Status.DONE if passed else Status.SKIPPED if skipped else Status.FAILED,
            note="skipped by the operator" if skipped else end.text or gate.failures,
            quality=gate.as_dict(),
            duration_s=rig.elapsed_s - start,
            samples=recorder.rows_taken,
        )
        self._close(recorder, taken, complete)
        if skipped:
            # the operator's act took the voltage off, and wants the next point
            rig.enable()
            return End(EndKind.FINISHED), True
        return end, passed

    def _close(self, recorder: Recorder, taken: Taken, complete: bool) -> None:
        def close() -> Taken:
            try:
                recorder.close(complete=complete, accepted=taken.status is Status.DONE, quality=taken.quality)
            except RecordingError as error:
                if taken.status is Status.DONE:
                    raise
                # it had failed before, and that has stopped the bench: the next run makes of it what can be made
                return replace(taken, note=str(error))
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
        number = next(expected.number for expected in self._points if expected.identity == identity)
        again = f"-take{take}" if take > 1 else ""
        return f"{number:04d}-{kind}{again}"

    def _write_manifest(self) -> None:
        try:
            self._put_manifest()
        except OSError as error:
            raise DeviceError(
                f"{self._folder}/campaign.json cannot be written: {error}; make room and run again"
            ) from error

    def _put_manifest(self) -> None:
        write_manifest(
            self._folder,
            {
                "campaign_id": self._campaign_id,
                "created_at": self._created,
                "bench": self._file.configuration.name,
                "plan": self._plan.as_dict(),
                "campaign_text": self._campaign.text,
                **end_and_zero(self._summary, self._rig.zeros.load_torque),
                "recordings": recordings(self._journal.takes(), self._points, self._journal.done()),
            },
        )
