"""Run a campaign on a rig: point after point into recordings, heating in between, until done, stopped or tripped."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path

from bench.campaigns.execution.outcome import end_of
from bench.campaigns.execution.points import Points
from bench.campaigns.execution.room import NoRoom, NotWritten, shortage
from bench.campaigns.execution.sequence_call import Stopped
from bench.campaigns.execution.shared import Shared
from bench.campaigns.execution.take import Takes
from bench.campaigns.execution.waits import Waits
from bench.campaigns.listener import Listener, Tap
from bench.campaigns.operator.directions import Directions
from bench.campaigns.planning.definition import Campaign
from bench.campaigns.planning.facts import facts
from bench.campaigns.planning.plan import Plan
from bench.campaigns.planning.registry import build_sequence
from bench.campaigns.planning.schedule import Task, schedule
from bench.campaigns.records.closer import Closer
from bench.campaigns.records.journal import Journal, campaign_digest
from bench.campaigns.records.manifest import end_and_zero, recordings
from bench.campaigns.records.rebuilt import CAMPAIGN_DIGEST, START_TEMPERATURE
from bench.campaigns.records.stop_log import StopLog
from bench.campaigns.taken import Status, Summary
from bench.campaigns.tare import TARE, TareSink
from bench.configuration import BenchFile
from bench.cycle.end import End, EndKind
from bench.cycle.rig import Rig
from bench.errors import BenchError, DeviceError, one_sentence
from bench.protocols import Point
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
    listener : receives the progress.
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
        self._shared = Shared(rig, file, folder, listener, directions or Directions(), tap, stop_requested)
        self._directions = self._shared.directions
        self._summary = Summary()
        self._torque = False
        self._waits = Waits(
            rig, self._directions, listener, self._shared.stop_requested, answered=directions is not None
        )
        self._stops = StopLog(folder)

    def run(self) -> Summary:
        """Run everything that is missing; the bench is at rest afterwards, whatever failed.

        Once there is torque, nothing that fails leaves here as an exception: it ends the run by the stop ladder, and
        the summary says why. Only a disk without room is raised as well, where nobody can be asked to make some.

        Raises
        ------
        ConfigurationError
            If the folder holds another campaign.
        LimitError
            If the disk has not enough room left for another point.
        DeviceError
            If a drive does not follow before there is torque; if journal or manifest cannot be written at the end.
        """
        rig, summary = self._rig, self._summary
        start = rig.elapsed_s
        with (
            Journal(self._folder, self._campaign, self._file) as self._journal,
            ThreadPoolExecutor(1, "recording-closer") as pool,
        ):
            self._closer = Closer(pool, self._journal, summary, self._listener)
            done = self._prepare()
            error: Exception | None = None
            try:
                if summary.earlier < len(self._points.expected):
                    self._measure(done)
            except Exception as failed:  # noqa: BLE001 - with torque it goes down the ladder, without it is raised again
                error = failed if not self._torque or isinstance(failed, NoRoom) else None
                # without torque there is nothing to bring to rest, and nothing to latch
                summary.end = self._shared.failed(failed) if self._torque else end_of(failed)
            finally:
                summary.bench_time_s = rig.elapsed_s - start
                summary.cycles = round(summary.bench_time_s / self._file.configuration.bus.cycle_time)
                self._conclude(error)
            if error is not None and not isinstance(error, Stopped):
                raise error
        return summary

    def _prepare(self) -> set[str]:
        """Ask for every point, report them, and return which are done already."""
        rig, summary = self._rig, self._summary
        for note in self._journal.notes:
            self._listener.noticed(note)
        self._campaign_id = self._journal.remember("id", f"{self._campaign.name}-{rig.now:%Y%m%dT%H%M%S}")
        self._created = self._journal.remember("created_at", datetime.now(UTC).isoformat())
        # points drawn between the start and the highest temperature must stay the same when a run goes on
        start_temperature = float(self._journal.remember("start_temperature", repr(rig.temperature)))
        # a journal that is lost is made anew of what stands in the recordings
        whose = {CAMPAIGN_DIGEST: campaign_digest(self._campaign), START_TEMPERATURE: start_temperature}
        self._stages = self._shared.call(
            f"the points of campaign {self._campaign.name}", lambda: self._campaign.points(start_temperature)
        )
        done = self._journal.done()
        self._points = Points.numbered(self._stages, self._file.digest, done)
        self._takes = Takes(
            self._shared, self._journal, self._closer, self._stops, self._points, self._campaign_id, whose
        )
        summary.earlier = sum(expected.done for expected in self._points.expected)
        zero = rig.zero_id or "unnamed"
        first = self._journal.remember("zero", zero)
        if first != zero:
            self._listener.noticed(f"encoder zero {zero}, begun with zero {first}: analyses keep recordings apart")
        self._listener.planned(self._campaign_id, self._plan, self._points.expected)
        return done

    def _conclude(self, error: Exception | None) -> None:
        """Write down what became of the run; where it failed before, that remains the reason that is reported."""
        failed = error is not None or self._summary.end.kind is EndKind.TRIPPED
        acts: tuple[Callable[[], None], ...] = (
            self._write_stops,
            lambda: self._closer.collect(wait=True),
            self._write_manifest,
        )
        for act in acts:
            try:
                act()
            except (BenchError, OSError) as second:
                if not failed:
                    raise
                self._listener.noticed(one_sentence(second))

    def _write_stops(self) -> None:
        self._stops.write(self._rig.stops)
        self._summary.stop_record = self._stops.last
        if self._stops.trouble is not None:
            self._listener.noticed(self._stops.trouble)

    def _measure(self, done: set[str]) -> None:
        rig, summary = self._rig, self._summary
        why = self._shortage()
        if why is not None:
            raise NoRoom(f"{why}; nothing has moved; make room and run again, finished points are not repeated")
        rig.enable()
        self._torque = True
        zero = self._measure_zero()
        if summary.end.kind is not EndKind.FINISHED:
            return
        rig.tare(zero)
        for stage, points in zip(self._campaign.stages, self._stages, strict=True):
            missing = [point for point in points if self._points.identity(point) not in done]
            band = self._file.configuration.heating.band
            for task in schedule(missing, stage.order, band, lambda: rig.temperature, self._left_out):
                summary.end = self._task(task)
                self._repeat()
                if summary.end.kind in (EndKind.TRIPPED, EndKind.INTERRUPTED):
                    return
        summary.tare_drift = self._measure_zero()

    def _left_out(self, point: Point) -> bool:
        """Wait while the operator pauses; then whether this point is to be skipped."""
        self._waits.while_paused()
        return self._directions.is_skipped(self._points.identity(point))

    def _shortage(self) -> str | None:
        """Return why no further point can be recorded at the moment, None if one can."""
        try:
            self._closer.collect(wait=False)
        except DeviceError as error:
            return str(error)
        return shortage(self._folder, self._file.configuration.storage.minimum_free)

    def _so_far(self) -> str:
        measured = sum(taken.status is Status.DONE for taken in self._summary.taken) + self._summary.earlier
        text = f"{measured} of {len(self._points.expected)} points are measured"
        return f"{text}, {self._closer.waiting} being closed" if self._closer.waiting else text

    def _repeat(self) -> None:
        """Measure once more what the operator asked for."""
        points = {expected.identity: expected.point for expected in self._points.expected}
        while (identity := self._directions.take_repeat()) is not None:
            if self._summary.end.kind in (EndKind.TRIPPED, EndKind.INTERRUPTED):
                return
            if identity in points and not self._left_out(points[identity]):
                self._summary.end = self._task(Task(points[identity]))

    def _measure_zero(self) -> float:
        sink = TareSink(self._rig.scaling)
        phases = build_sequence(TARE.sequence).phases(TARE, facts(self._file.configuration))
        end = self._rig.run(phases, self._shared.watched(sink, TARE.sequence), self._shared.stop_requested)
        self._summary.end = end
        return sink.zero if end.kind is EndKind.FINISHED else math.nan

    def _task(self, task: Task) -> End:
        end, takes = End(EndKind.FINISHED), 0
        while takes < MOST_TAKES:
            if self._shared.stop_requested():
                return self._shared.failed(Stopped("stopped on the operator's request"))
            why = self._shortage()
            if why is not None:
                self._waits.for_room(why, self._so_far())
                continue
            try:
                end, passed = self._takes.record(task)
            except NotWritten as error:
                self._waits.for_room(str(error), self._so_far())
                continue
            takes += 1
            if passed or end.kind in (EndKind.TRIPPED, EndKind.INTERRUPTED) or task.is_preparation:
                break
        return end

    def _write_manifest(self) -> None:
        content = {
            "campaign_id": self._campaign_id,
            "created_at": self._created,
            "bench": self._file.configuration.name,
            "plan": self._plan.as_dict(),
            "campaign_text": self._campaign.text,
            **end_and_zero(self._summary, self._rig.zeros.load_torque),
            "recordings": recordings(self._journal.takes(), self._points.expected, self._journal.done()),
        }
        try:
            write_manifest(self._folder, content)
        except OSError as error:
            raise DeviceError(
                f"{self._folder}/campaign.json cannot be written: {error}; make room and run again"
            ) from error
