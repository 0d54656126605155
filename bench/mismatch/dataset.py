"""A folder of recordings as rows to compare: read once, reduced to blocks, split by operating point."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path

from bench.errors import RecordingError
from bench.mismatch.collected import Collected
from bench.mismatch.comparable import Comparable
from bench.mismatch.lines import OrderSpectrum
from bench.mismatch.mapping import over
from bench.mismatch.motion import Manner
from bench.mismatch.motor_ripple import ShaftSpectrum
from bench.mismatch.pieces import Piece, pieces
from bench.mismatch.prepare import MEASURED, prepare
from bench.mismatch.rows import Rows, join
from bench.mismatch.split import point_of, split, split_blocks
from bench.mismatch.tones import ToneSpectrum
from bench.recording import Recording, RecordingFolder

SAMPLES_A_PROCESS = 8_000_000
THERMAL_KINDS = ("heating", "cooling", "dwell")


@dataclass(frozen=True, slots=True)
class Member:
    """One recording of the data set, or a block of one."""

    index: int
    recording: Recording
    point: tuple[str, float, float, float]
    held_out: bool
    fold: int
    zero: str | None
    name: str


@dataclass(slots=True)
class Dataset:
    """Recordings of a folder, reduced. ``slow[channel]``, ``heat`` and ``angle`` hold rows of all recordings, in
    order.
    """

    members: list[Member]
    rejected: list[tuple[str, str]]
    slow: dict[str, Rows] = field(default_factory=dict)
    heat: Rows | None = None
    angle: Rows | None = None
    shaft: list[ShaftSpectrum] = field(default_factory=list)
    tones: dict[str, list[ToneSpectrum]] = field(default_factory=dict)
    lines: dict[str, list[OrderSpectrum]] = field(default_factory=dict)
    campaign_start: float = 0.0
    notes: list[str] = field(default_factory=list)

    @property
    def ratio(self) -> float:
        """Gear ratio u of the recordings."""
        return float(self.members[0].recording.gearbox.ratio or 1.0)

    @property
    def linear(self) -> bool:
        """Whether the recordings are of a linear axis, whose motor_angle is a length."""
        specs = self.members[0].recording.specs
        return "motor_angle" in specs and specs["motor_angle"].unit == "m"

    def held_out(self) -> set[int]:
        """Indices of the recordings that are scored and never fitted."""
        return {m.index for m in self.members if m.held_out}


def _usable(recording: Recording) -> str | None:
    if recording.size < 50:
        return f"{recording.path.name} has {recording.size} samples; at least 50 are needed to say anything"
    if recording.gearbox.ratio is None:
        return f"{recording.path.name} names no gear ratio (gearbox/ratio); without it no angle can be compared"
    if not any(name in recording for name in ("load_angle", "motor_torque", "load_torque", "temperature")):
        return f"{recording.path.name} has none of the channels that are compared"
    return None


def load(path: Path, progress: Callable[[str, float], None] | None = None, jobs: int = 1) -> Dataset:
    """Read a folder of recordings (or a list in a manifest's folder) and reduce it, on ``jobs`` processes.

    Raises RecordingError where no recording can be used.
    """
    folder = RecordingFolder.open(path)
    rejected = [(str(r.file), r.why) for r in folder.rejected]
    usable: list[Recording] = []
    for recording in folder.recordings:
        why = _usable(recording)
        if why is None:
            usable.append(recording)
        else:
            rejected.append((recording.path.name, why))
    if not usable:
        raise RecordingError(f"{path} holds no recording that can be compared; see `bench validate` for each file")
    usable.sort(key=lambda r: r.started_at)
    usable = _of_one_gearbox(usable, rejected)
    parts, note = pieces(usable)
    held, fold = split_blocks(parts) if note else split(usable)
    data = Dataset([], rejected, campaign_start=usable[0].started_at.timestamp(), notes=[note] if note else [])
    comparable = Comparable.of(usable, data.notes)
    if all("motor_angle" in r.specs and r.specs["motor_angle"].unit == "m" for r in usable):
        data.notes.append("a linear axis: read rad as m and N*m as N; 1 deg/s in a location is 17.5 mm/s")
    manner = Manner.of(usable)
    rows = Collected()
    travelled = 0.0
    tasks = _tasks(parts, data.campaign_start, manner, comparable)
    # a process takes seconds to start: it is worth that for some million samples only
    workers = min(jobs, 1 + sum(r.size for r in usable) // SAMPLES_A_PROCESS)
    for task, read in zip(tasks, over(_read, tasks, workers), strict=True):
        if progress is not None:
            progress("reading", task.pieces[0][0] / len(parts))
        recording = task.pieces[0][1].recording
        if read.why:
            rejected += [(recording.path.name, read.why)] * len(task.pieces)
            continue
        read.rows.travelled_before(travelled)
        travelled += read.travel
        rows.take(read.rows)
        for number, part in task.pieces:
            data.members.append(
                Member(number, recording, point_of(recording), held[number], fold[number], recording.zero_id, part.name)
            )
            if read.dead:
                told = f"{part.name} holds no number in {', '.join(sorted(read.dead))}: not compared where it is needed"
                data.notes.append(told)
    if not data.members:
        raise RecordingError(f"{path} holds no recording that can be read; see `bench validate` for each file")
    data.slow = {channel: join(rows.slow[channel]) for channel in MEASURED if channel in rows.slow}
    data.heat = join(rows.heat) if rows.heat else None
    data.angle = join(rows.angle) if rows.angle else None
    data.shaft, data.tones, data.lines = rows.shaft, rows.tones, rows.lines
    return data


@dataclass(frozen=True, slots=True)
class _Task:
    """A recording to read: its pieces with their numbers, and what all recordings share."""

    pieces: tuple[tuple[int, Piece], ...]
    campaign_start: float
    manner: Manner
    comparable: Comparable


def _tasks(parts: Sequence[Piece], start: float, manner: Manner, comparable: Comparable) -> list[_Task]:
    """One task a recording; the pieces of one follow each other."""
    groups = groupby(enumerate(parts), key=lambda pair: id(pair[1].recording))
    return [_Task(tuple(own), start, manner, comparable) for _, own in groups]


@dataclass(frozen=True, slots=True)
class _Read:
    """What a recording came to: rows, the distance run in it (rad at the output), channels without a number; or why it
    cannot be read.
    """

    rows: Collected
    travel: float = 0.0
    dead: frozenset[str] = frozenset()
    why: str = ""


def _read(task: _Task) -> _Read:
    recording = task.pieces[0][1].recording
    rows = Collected()
    try:
        prepared = prepare(recording, task.pieces[0][0], task.campaign_start, 0.0, task.manner)
    except (RecordingError, OSError, ValueError) as error:
        return _Read(rows, why=f"{recording.path.name} cannot be read: {error}")
    channels = task.comparable.channels(recording, prepared.dead)
    for number, part in task.pieces:
        rows.add(part.cut(prepared, number), channels)
    return _Read(rows, float(prepared.frame.travel[-1]), prepared.dead)


def _of_one_gearbox(recordings: list[Recording], rejected: list[tuple[str, str]]) -> list[Recording]:
    """The recordings of the ratio that most have; the others are rejected."""
    ratios = [float(r.gearbox.ratio or 1.0) for r in recordings]
    usual = max(set(ratios), key=ratios.count)
    for recording, ratio in zip(recordings, ratios, strict=True):
        if ratio != usual:
            why = f"is of a gearbox of ratio {ratio:g}, most of the folder of {usual:g}: not one bench"
            rejected.append((recording.path.name, f"{recording.path.name} {why}"))
    return [r for r, ratio in zip(recordings, ratios, strict=True) if ratio == usual]
