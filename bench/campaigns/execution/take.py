"""One take of a point: header, recorder, motion, the judgement of its quality, the finished file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from bench.campaigns.execution.outcome import judge_take
from bench.campaigns.execution.points import Points
from bench.campaigns.execution.room import NotWritten
from bench.campaigns.execution.sequence_call import Stopped
from bench.campaigns.execution.shared import Shared
from bench.campaigns.planning.facts import facts
from bench.campaigns.planning.registry import build_sequence
from bench.campaigns.planning.schedule import Task
from bench.campaigns.planning.soundness import check_phases
from bench.campaigns.records.closer import Closer
from bench.campaigns.records.journal import Journal
from bench.campaigns.records.provenance import recording_header
from bench.campaigns.records.recorder import Recorder
from bench.campaigns.records.stop_log import StopLog
from bench.campaigns.taken import Status, Taken, commanded_velocity, setpoint_dict
from bench.cycle.end import End, EndKind
from bench.errors import DeviceError, RecordingError


class Takes:
    """Makes the recordings of a run.

    Parameters
    ----------
    shared : bench, folder, listeners.
    journal, closer, stops : where takes are noted, finished, and their stops written.
    points : of the run.
    campaign_id : of the run's campaign.
    whose : attributes by which a lost journal is rebuilt from the recordings.
    """

    def __init__(
        self,
        shared: Shared,
        journal: Journal,
        closer: Closer,
        stops: StopLog,
        points: Points,
        campaign_id: str,
        whose: Mapping[str, Any],
    ) -> None:
        self._shared, self._points = shared, points
        self._journal, self._closer, self._stops = journal, closer, stops
        self._campaign_id, self._whose = campaign_id, whose

    def record(self, task: Task) -> tuple[End, bool]:
        """Record a task once; return how its motion ended, and whether the point needs no further take."""
        point, rig, config = task.point, self._shared.rig, self._shared.file.configuration
        sequence = build_sequence(point.sequence, point.options)
        what = f'sequence "{point.sequence}" for {point.label}'
        # looked at again: it need not say the same as when it was planned
        phases = self._shared.call(what, lambda: check_phases(sequence.phases(point, facts(config)), config, what))
        identity = self._points.identity(point)
        take = self._journal.next_take(identity)
        name = self._points.name(task, identity, sequence.kind, take)
        setpoint = {**setpoint_dict(point), "velocity": commanded_velocity(point, phases)}
        begun = Taken(name, f"{name}.h5", sequence.kind, point.label, setpoint, identity, take, Status.PENDING)
        header = recording_header(begun, self._campaign_id, self._shared.file, rig, self._whose)
        try:
            self._journal.begin(begun)
            recorder = Recorder(
                self._shared.folder / begun.file,
                header,
                rig.scaling,
                fast=not rig.is_real_time,
                ratio=config.gearbox.ratio,
            )
        except (DeviceError, RecordingError) as error:
            raise NotWritten(str(error)) from error
        start, complete = rig.elapsed_s, False
        taken = replace(begun, status=Status.FAILED, complete=False)
        try:
            self._shared.listener.started(task, name)
            end = rig.run(
                phases,
                self._shared.watched(recorder, sequence.kind),
                self._stop_for(task, recorder),
                self._points.where(task),
            )
            skipped = end.kind is EndKind.INTERRUPTED and not self._shared.stop_requested()
            taken, complete = judge_take(begun, point, recorder, end, skipped, config)
            if recorder.ended is not None:
                self._shared.listener.noticed(recorder.ended)
        except Exception as error:  # noqa: BLE001 - whatever it was: the bench comes to rest, the file is finished
            end = self._shared.failed(error, recorder)
            taken = replace(taken, note=end.text)
        taken = replace(taken, duration_s=rig.elapsed_s - start, samples=recorder.rows_taken)
        if not self._close(recorder, taken, complete):
            end = self._shared.failed(Stopped("stopped on the operator's request"))
        self._stops.write(rig.stops, name)
        if taken.status is Status.SKIPPED:
            # the operator's act took the voltage off, and wants the next point
            rig.enable()
            return End(EndKind.FINISHED), True
        return end, taken.status is Status.DONE

    def _stop_for(self, task: Task, recorder: Recorder) -> Callable[[], bool]:
        """Return what is asked between blocks of a recording: whether it is to end."""
        skippable = self._points.identity(task.prepares or task.point)

        def stop() -> bool:
            self._shared.listener.advanced(self._shared.rig.elapsed_s, self._shared.rig.temperature)
            for note in self._shared.directions.take_notes():
                why = recorder.remark(note)
                if why is not None:
                    self._shared.listener.noticed(f'the remark "{note}" could not be written: {why}')
            return self._shared.stop_requested() or self._shared.directions.is_skipped(skippable)

        return stop

    def _close(self, recorder: Recorder, taken: Taken, complete: bool) -> bool:
        """Finish the file while the bus goes on; False if the operator wants the bench at rest meanwhile."""
        self._closer.close(recorder, taken, complete)
        while self._shared.rig.is_real_time and self._closer.is_busy:
            # the bus must not fall silent while a file is finished, or the drives' watchdogs act
            self._shared.rig.idle()
            if self._shared.rig.has_torque and self._shared.stop_requested():
                # a frozen disk may take for ever; the file is still finished before the run ends
                return False
        try:
            # at most one file may be on its way to the disk while the next is being made
            self._closer.collect(wait=self._closer.waiting > 1)
        except DeviceError as error:
            # kept, and tried again before the next point, which waits for it
            self._shared.listener.noticed(str(error))
        return True
