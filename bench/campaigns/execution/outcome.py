"""Result of a take, and of a run that failed: pure functions of what was recorded."""

from __future__ import annotations

import traceback
from dataclasses import replace

from bench.campaigns.execution.gate import judge
from bench.campaigns.execution.room import NoRoom
from bench.campaigns.execution.sequence_call import Stopped
from bench.campaigns.records.recorder import Recorder
from bench.campaigns.taken import Status, Taken
from bench.configuration import BenchConfiguration
from bench.cycle.end import End, EndKind
from bench.errors import BenchError, RecordingError, one_sentence
from bench.protocols import Point
from bench.safety import Cause


def judge_take(
    begun: Taken, point: Point, recorder: Recorder, end: End, skipped: bool, bench: BenchConfiguration
) -> tuple[Taken, bool]:
    """Return what became of a take, and whether it went on to its end; what was poor stands in its events.

    ``skipped`` says that the operator did not want the point any more.
    """
    gate = judge(point, begun.kind, recorder.figures, bench)
    whole = recorder.ended is None
    complete = end.kind in (EndKind.FINISHED, EndKind.EXPIRED) and whole
    passed = end.kind is EndKind.FINISHED and gate.passed and whole
    if end.kind is EndKind.EXPIRED:
        recorder.event("warning", end.text)
    if complete and not gate.passed:
        recorder.event("warning", f"quality gate: {gate.failures}")
    taken = replace(
        begun,
        status=Status.DONE if passed else Status.SKIPPED if skipped else Status.FAILED,
        note="skipped by the operator" if skipped else end.text or recorder.ended or gate.failures,
        quality=gate.as_dict(),
        complete=complete,
    )
    return taken, complete


def end_of(error: Exception) -> End:
    """Return the end a failure makes of a run with torque; one that is no error for users leaves its trace in the log.

    A stop by the operator, and a disk that nobody makes room on, are no reason to latch.
    """
    if isinstance(error, Stopped | NoRoom):
        return End(EndKind.INTERRUPTED, one_sentence(error), Cause.OPERATOR)
    if not isinstance(error, BenchError):
        traceback.print_exception(error)
    cause = Cause.RECORDER if isinstance(error, RecordingError) else Cause.PROGRAM
    return End(EndKind.TRIPPED, one_sentence(error), cause)
