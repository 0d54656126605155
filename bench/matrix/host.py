"""Rows of the computer the bench runs on: its disk, its clock, and a second run where one is already."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime, timedelta, tzinfo
from pathlib import Path
from typing import Any

from bench.configuration import BenchFile
from bench.cycle.assembly import assemble
from bench.cycle.rig import Rig
from bench.errors import BenchError, RecordingError
from bench.matrix.outcome import Outcome
from bench.matrix.plant import (
    judge_end,
    judge_shafts,
    judge_stop,
    motion,
    read_back,
    record,
    strike_cycle,
    with_block,
)
from bench.matrix.rows import Row
from bench.matrix.shafts import Shafts
from bench.protocols import Phase, Segment
from bench.recording import Recording
from bench.recording.repairing import repair
from bench.safety import LatchFile

_REST = (Phase(Segment.DWELL, 0.5, 0.0, 0.0),)
_ROOM = 700_000
"""Bytes a file may have on the full disk: a recording begins and does not end."""
_JUMP = timedelta(hours=1)


def run_host_row(row: Row, file: BenchFile, folder: Path, seed: int = 0) -> Outcome:
    """Record once undisturbed, then again on a computer that is not well."""
    outcome = Outcome(row.name, row.text, row.kind)
    _RUNS[row.name](row, outcome, with_block(file, row.block), folder, seed)
    return outcome


def _disk_full(row: Row, outcome: Outcome, file: BenchFile, folder: Path, seed: int) -> None:
    bench = file.configuration
    assembly = assemble(bench, seed=seed, real_time=False)
    master: Any = assembly.master
    with Rig(file, assembly=assembly, latch=LatchFile(folder / "latch.json")) as rig:
        rig.enable()
        _, earlier = record(rig, file, folder, "earlier", _REST)
        offset, refused = master.bench.cycle - rig.link.cycle, list[int]()
        changed = _patched_class("bench.recording.writing.ordered_file", "OrderedFile", _refusing(refused, master))
        with _files_end_at(_ROOM), changed:
            end, shafts = _recorded_or_not(rig, file, folder, motion(bench, 600.0))
        judge_end(row, outcome, rig, end, shafts)
        shafts.look()
        outcome.require(bool(refused), "the disk refused nothing, so nothing was tried")
        if refused:
            outcome.struck = shafts.at(refused[0])
            judge_stop(row, outcome, rig, shafts, refused[0], offset)
        judge_shafts(outcome, bench, shafts)
    read_back(outcome, folder, {"earlier": earlier})
    try:
        rows = Recording.open(repair(folder / "struck.h5.part").path).size
    except RecordingError as error:
        outcome.require(False, f"what was written before cannot be read: {error}")
    else:
        outcome.require(rows > 0, "nothing of the recording was kept")
        outcome.read_back += 1


def _slow_disk(row: Row, outcome: Outcome, file: BenchFile, folder: Path, seed: int) -> None:
    with _patched_class("bench.recording.writing.ordered_file", "OrderedFile", _slow):
        _run_to_end(row, outcome, file, folder, seed)


def _clock_step(row: Row, outcome: Outcome, file: BenchFile, folder: Path, seed: int) -> None:
    with _jumping_clock() as calls:
        _run_to_end(row, outcome, file, folder, seed)
    outcome.require(calls[0] > 0, "nobody looked at the clock, so nothing was tried")
    recording = Recording.open(folder / "struck.h5")
    times = recording.si("time")
    outcome.require(
        bool(abs(times[-1] - (times.size - 1) * file.configuration.bus.cycle_time) < 1e-6),
        "the recording's times are not those of the bus",
    )


def _two_runs_in_a_folder(row: Row, outcome: Outcome, file: BenchFile, folder: Path, seed: int) -> None:
    from bench.campaigns import load_campaign
    from bench.campaigns.execution.session import run_campaign
    from bench.campaigns.records.journal import Journal

    campaign = load_campaign("quick")
    with Journal(folder, campaign, file):
        try:
            run_campaign(file, campaign, folder, seed=seed)
            outcome.reaction = "not refused"
        except BenchError as error:
            outcome.sentence, outcome.reaction = str(error), "refused"
    outcome.require(
        row.expected_text in outcome.sentence,
        f"the second run was not refused with '{row.expected_text}': {outcome.sentence}",
    )
    outcome.require(not list(folder.glob("*.h5*")), "the second run recorded something")


_RUNS: dict[str, Callable[[Row, Outcome, BenchFile, Path, int], None]] = {
    "disk_full": _disk_full,
    "slow_disk": _slow_disk,
    "clock_step": _clock_step,
    "two_runs_in_a_folder": _two_runs_in_a_folder,
}


def _run_to_end(row: Row, outcome: Outcome, file: BenchFile, folder: Path, seed: int) -> None:
    """A run that has to end as if nothing were wrong."""
    assembly = assemble(file.configuration, seed=seed, real_time=False)
    with Rig(file, assembly=assembly) as rig:
        rig.enable()
        _, earlier = record(rig, file, folder, "earlier", _REST)
        at = strike_cycle(rig)
        end, shafts = record(rig, file, folder, "struck", motion(file.configuration, row.last_s))
        judge_end(row, outcome, rig, end, shafts)
        outcome.struck = shafts.at(at)
        judge_shafts(outcome, file.configuration, shafts)
        master: Any = assembly.master
        outcome.drives = {drive.role: drive.state.name for drive in master.bench.drives}
    read_back(outcome, folder, {"earlier": earlier, "struck": shafts})


def _recorded_or_not(rig: Rig, file: BenchFile, folder: Path, phases: tuple[Phase, ...]) -> tuple[Any, Shafts]:
    """Record as ever; closing a file that could not be written fails once more, which nobody waits for."""
    from bench.campaigns.records.recorder import Recorder
    from bench.matrix.plant import header

    ratio = file.configuration.gearbox.ratio
    recorder = Recorder(folder / "struck.h5", header(file, rig, "struck"), rig.scaling, fast=True, ratio=ratio)
    shafts = Shafts(recorder, rig.link.assembly.master)
    end = rig.run(phases, shafts, lambda: False)
    try:
        recorder.close(complete=False, accepted=None, quality=None)
    except RecordingError as error:
        shafts.events.append(str(error))
    return end, shafts


@contextmanager
def _files_end_at(size: int) -> Iterator[None]:
    """Refuse every byte of a file beyond a size, as a full disk does (the error is EFBIG instead of ENOSPC)."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def _refusing(refused: list[int], master: Any) -> Callable[[Any], Any]:
    """Return a change of the file that notes the bench's cycle whenever the disk refuses to take bytes."""

    def change(kind: Any) -> Any:
        class Refusing(kind):  # type: ignore[misc]
            def _write_all(self, offset: int, data: bytes) -> None:
                try:
                    super()._write_all(offset, data)
                except OSError:
                    refused.append(int(master.bench.cycle))
                    raise

        return Refusing

    return change


def _slow(kind: Any) -> Any:
    """Return a file of which every commit takes half a second."""

    class Slow(kind):  # type: ignore[misc]
        def commit(self) -> None:
            time.sleep(0.5)
            super().commit()

    return Slow


@contextmanager
def _jumping_clock() -> Iterator[list[int]]:
    """Let every second look at the time of day be an hour ahead; yields how often it was looked at."""
    calls = [0]
    real = datetime  # this module's own name is replaced as well

    class Jumping(datetime):
        @classmethod
        def now(cls, tz: tzinfo | None = None) -> Any:
            calls[0] += 1
            return super().now(tz) + _JUMP * (calls[0] % 2)

    modules = [m for name, m in sys.modules.items() if name.startswith("bench.") and getattr(m, "datetime", 0) is real]
    for module in modules:
        module.datetime = Jumping  # type: ignore[attr-defined]
    try:
        yield calls
    finally:
        for module in modules:
            module.datetime = real  # type: ignore[attr-defined]


@contextmanager
def _patched_class(module: str, name: str, change: Callable[[Any], Any]) -> Iterator[None]:
    """Replace a class wherever the program has imported it."""
    kind = getattr(sys.modules[module], name)
    changed = change(kind)
    users = [m for key, m in sys.modules.items() if key.startswith("bench.") and getattr(m, name, None) is kind]
    for user in users:
        setattr(user, name, changed)
    try:
        yield
    finally:
        for user in users:
            setattr(user, name, kind)
