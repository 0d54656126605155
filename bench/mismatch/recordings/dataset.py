"""A folder of recordings as rows to compare: read once, reduced, split by operating point."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby

import numpy as np

from bench.errors import RecordingError
from bench.foreign.base import Base
from bench.mismatch import criteria
from bench.mismatch.mapping import over
from bench.mismatch.memory import give_back
from bench.mismatch.recordings.comparable import Comparable
from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.notch import ripple_orders
from bench.mismatch.recordings.output_orders import OutputSpectrum, output_spectra
from bench.mismatch.recordings.pieces import Piece, pieces
from bench.mismatch.recordings.prepared import Folder, Prepared, prepare
from bench.mismatch.recordings.rows import Rows, angle_rows, heat_rows, join, slow_rows
from bench.mismatch.recordings.source import Paths, folders_of, gathered, names_of
from bench.mismatch.recordings.split import point_of, split, split_blocks
from bench.mismatch.recordings.vibration import Density, ShaftSpectrum, density, shaft_spectrum
from bench.recording import Recording
from bench.recording.header import Gearbox
from bench.simulation.quantities import AUXILIARY
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR

Progress = Callable[[str, float], None]
SAMPLES_A_PROCESS = 8_000_000
"""a process takes seconds to start: it is worth that for some million samples only"""
LEAST_SAMPLES = 50
AT_ONE_POINT = ("constant_velocity", "reversal", "dwell")
"""kinds of recordings that show one speed and one load each"""


@dataclass(frozen=True, slots=True)
class Member:
    """One recording of the data set, or a block of one."""

    index: int
    recording: Recording
    point: tuple[str, float, float, float]
    held_out: bool
    fold: int
    name: str


@dataclass(slots=True)
class Collected:
    """Rows and spectra of the recordings read so far, by channel."""

    rows: dict[str, list[Rows]] = field(default_factory=dict)
    density: dict[str, list[Density]] = field(default_factory=dict)
    shaft: list[ShaftSpectrum] = field(default_factory=list)
    output: dict[str, list[OutputSpectrum]] = field(default_factory=dict)

    def add(self, prepared: Prepared, channels: frozenset[str], manner: Manner) -> None:
        """Reduce a recording in the channels in which it can be compared."""
        for channel in sorted(channels & set(prepared.measured)):
            if channel == TEMPERATURE:
                self.rows.setdefault(channel, []).append(heat_rows(prepared))
                continue
            if channel == TRANSMISSION_ERROR:
                if prepared.kind != "heating":  # the series does not hold at heating speed
                    self.rows.setdefault(channel, []).append(angle_rows(prepared))
            else:
                self.rows.setdefault(channel, []).append(slow_rows(prepared, channel, manner))
            heard = density(prepared, channel)
            if heard is not None:
                self.density.setdefault(channel, []).append(heard)
            self.output.setdefault(channel, []).extend(
                output_spectra(prepared, channel) if channel in (MOTOR_TORQUE, LOAD_TORQUE) else ()
            )
            if channel == MOTOR_TORQUE:
                shaft = shaft_spectrum(prepared)
                if shaft is not None:
                    self.shaft.append(shaft)

    def travelled_before(self, distance: float) -> None:
        """Count the distance run before these recordings, rad at the output."""
        for rows in self.rows.values():
            rows[:] = [replace(r, frame=replace(r.frame, travel=r.frame.travel + distance)) for r in rows]

    def take(self, other: Collected) -> None:
        """Append the rows of further recordings."""
        for channel, rows in other.rows.items():
            self.rows.setdefault(channel, []).extend(rows)
        for channel, heard in other.density.items():
            self.density.setdefault(channel, []).extend(heard)
        for channel, turns in other.output.items():
            self.output.setdefault(channel, []).extend(turns)
        self.shaft += other.shaft


@dataclass(slots=True)
class Dataset:
    """Recordings of a folder, reduced. ``rows[channel]`` holds rows of all recordings, in order."""

    members: list[Member]
    rejected: list[tuple[str, str]]
    folder: Folder
    rows: dict[str, Rows] = field(default_factory=dict)
    density: dict[str, list[Density]] = field(default_factory=dict)
    shaft: list[ShaftSpectrum] = field(default_factory=list)
    output: dict[str, list[OutputSpectrum]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    parts: list[Piece] = field(default_factory=list)
    travelled: dict[str, float] = field(default_factory=dict)
    """distance run before each recording in this campaign, rad at the output, by the recording's path"""
    simulated: frozenset[str] = frozenset()
    """channels that a simulation from elsewhere predicts; they hold what it leaves"""

    @property
    def gearbox(self) -> Gearbox:
        """Gearbox of the recordings, as their headers have it."""
        return self.members[0].recording.gearbox

    @property
    def ratio(self) -> float:
        """Gear ratio u of the recordings."""
        return float(self.members[0].recording.gearbox.ratio or 1.0)

    @property
    def linear(self) -> bool:
        """Whether the recordings are of a linear axis, whose motor_angle is a length."""
        return is_linear(self.members[0].recording)

    @property
    def cut(self) -> bool:
        """Whether recordings are pieces of a few longer ones: then a sensor's zero is not each piece's own."""
        whole = {m.recording.imported_from or str(m.recording.path) for m in self.members}
        return len(whole) < len(self.members)

    @property
    def auxiliary_units(self) -> dict[str, str]:
        """Units of the quantities that are no channels of the bench, by name without ``aux/``."""
        named = [(name, spec.unit) for m in self.members for name, spec in m.recording.specs.items()]
        return {name.removeprefix(AUXILIARY): unit for name, unit in named if name.startswith(AUXILIARY)}

    @property
    def present(self) -> frozenset[str]:
        """Channels that some recording has."""
        return frozenset(name for m in self.members for name in m.recording.channels)

    def held_out(self) -> set[int]:
        """Indices of the recordings that are scored and never fitted."""
        return {m.index for m in self.members if m.held_out}

    def folds(self) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
        """Fold of each recording by its index; -1 for those held out or not there."""
        size = max(m.index for m in self.members) + 1
        out = np.full(size, -1, dtype=np.int64)
        for m in self.members:
            out[m.index] = m.fold
        return out

    def name(self, index: int) -> str:
        """Name of a recording by its index."""
        return next(m.name for m in self.members if m.index == index)


def is_linear(recording: Recording) -> bool:
    """Whether a recording is of a linear axis."""
    return "motor_angle" in recording.specs and recording.specs["motor_angle"].unit == "m"


def _usable(recording: Recording) -> str | None:
    if recording.size < LEAST_SAMPLES:
        return (
            f"{recording.path.name} has {recording.size} samples; at least {LEAST_SAMPLES} are needed to say anything"
        )
    if recording.gearbox.ratio is None:
        return f"{recording.path.name} names no gear ratio (gearbox/ratio); without it no angle can be compared"
    if not any(name in recording.specs for name in ("load_angle", "motor_torque", "load_torque", "temperature")):
        return (
            f"{recording.path.name} has none of the channels that are compared (motor_torque, load_torque, load_angle,"
            " temperature); the mapping of the import should name one"
        )
    return None


def load(path: Paths, progress: Progress | None = None, jobs: int = 1, base: Base | None = None) -> Dataset:
    """Read a folder of recordings, or several as one, and reduce it, on ``jobs`` processes; ``base``: a simulation from
    elsewhere.

    Raises RecordingError where no recording can be used, ConfigurationError where folders are no one data set.
    """
    found, rejected = gathered(path)
    usable: list[Recording] = []
    for recording in found:
        why = _usable(recording)
        if why is None:
            usable.append(recording)
        else:
            rejected.append((recording.path.name, why))
    if not usable:
        first = f": {rejected[0][1]}" if rejected else ""
        raise RecordingError(f"{_named(path)} holds no recording that can be compared{first}")
    usable.sort(key=lambda r: r.started_at)
    usable = _of_one_gearbox(usable, rejected)
    parts, note = pieces(usable)
    called = {str(r.path): name for r, name in zip(usable, names_of(usable), strict=True)}
    held, fold = split_blocks(parts) if note else split(usable)
    notes = [note] if note else []
    comparable = Comparable.of(usable, notes)
    if all(is_linear(r) for r in usable):
        notes.append("a linear axis: metres and newtons")
    folder = Folder(usable[0].started_at.timestamp(), Manner.of(usable), ripple_orders(usable), base)
    data = Dataset([], rejected, folder, notes=notes, parts=parts)
    rows = Collected()
    travelled = 0.0
    tasks = _tasks(parts, folder, comparable)
    workers = min(jobs, 1 + sum(r.size for r in usable) // SAMPLES_A_PROCESS)
    for task, read in zip(tasks, over(_read, tasks, workers), strict=True):
        if progress is not None:
            progress("reading", task.pieces[0][0] / len(parts))
        recording = task.pieces[0][1].recording
        if not read.why and data.members and read.simulated != data.simulated:
            read = replace(read, why=_otherwise(recording, read.simulated, data.simulated))
        if read.why:
            rejected += [(recording.path.name, read.why)] * len(task.pieces)
            continue
        read.rows.travelled_before(travelled)
        data.travelled[str(recording.path)] = travelled
        travelled += read.travel
        rows.take(read.rows)
        data.simulated = read.simulated
        for number, part in task.pieces:
            title = called[str(recording.path)] + part.name.removeprefix(recording.recording_id)
            data.members.append(Member(number, recording, point_of(recording), held[number], fold[number], title))
        if read.dead:
            told = f"{recording.recording_id} holds no number in {', '.join(sorted(read.dead))}"
            notes.append(f"{told}: not compared where it is needed")
    if not data.members:
        if base is not None and rejected:
            raise RecordingError(rejected[0][1])
        raise RecordingError(f"{_named(path)} holds no recording that can be read; see `bench validate` for each file")
    data.rows = {channel: join(rows.rows.pop(channel)) for channel in list(rows.rows)}
    give_back()
    data.density, data.shaft, data.output = rows.density, rows.shaft, rows.output
    return data


def _named(path: Paths) -> str:
    return ", ".join(str(folder) for folder in folders_of(path))


@dataclass(frozen=True, slots=True)
class _Task:
    """A recording to read: its pieces with their numbers, and what all recordings share."""

    pieces: tuple[tuple[int, Piece], ...]
    folder: Folder
    comparable: Comparable


def _tasks(parts: Sequence[Piece], folder: Folder, comparable: Comparable) -> list[_Task]:
    """One task a recording; the pieces of one follow each other."""
    groups = groupby(enumerate(parts), key=lambda pair: id(pair[1].recording))
    return [_Task(tuple(group), folder, comparable) for _, group in groups]


@dataclass(frozen=True, slots=True)
class _Read:
    """What a recording came to: rows, the distance run in it (rad at the output), channels without a number; or why it
    cannot be read.
    """

    rows: Collected
    travel: float = 0.0
    dead: frozenset[str] = frozenset()
    why: str = ""
    simulated: frozenset[str] = frozenset()


def _read(task: _Task) -> _Read:
    recording = task.pieces[0][1].recording
    rows = Collected()
    try:
        prepared = prepare(recording, task.pieces[0][0], task.folder)
    except (RecordingError, OSError, ValueError) as error:
        return _Read(rows, why=f"{recording.path.name} cannot be read: {error}")
    channels = task.comparable.channels(recording, prepared.dead)
    for number, part in task.pieces:
        rows.add(part.cut(prepared, number), channels, task.folder.manner)
    return _Read(rows, float(prepared.frame.travel[-1]), prepared.dead, "", frozenset(prepared.simulated))


def _otherwise(recording: Recording, here: frozenset[str], others: frozenset[str]) -> str:
    listed, rest = (", ".join(sorted(names)) or "nothing" for names in (here, others))
    return f"{recording.path.name}: the simulation predicts {listed} of it, of the recordings before it {rest}"


def _of_one_gearbox(recordings: list[Recording], rejected: list[tuple[str, str]]) -> list[Recording]:
    """The recordings of the ratio that most have; the others are rejected."""
    ratios = [float(r.gearbox.ratio or 1.0) for r in recordings]
    usual = max(set(ratios), key=ratios.count)
    for recording, ratio in zip(recordings, ratios, strict=True):
        if ratio != usual:
            why = f"is of a gearbox of ratio {ratio:g}, most of the folder of {usual:g}: not one bench"
            rejected.append((recording.path.name, f"{recording.path.name} {why}"))
    return [r for r, ratio in zip(recordings, ratios, strict=True) if ratio == usual]


def enough(data: Dataset) -> str:
    """Why a data set is too small to tell noise from structure; empty where it is not."""
    least = criteria.FEWEST_RECORDINGS
    train = sum(not m.held_out for m in data.members)
    if train < least:
        return f"{train} recordings can be fitted, at least {least} are needed to distinguish noise from structure"
    points = {m.point[1:3] for m in data.members}
    if all(m.recording.kind in AT_ONE_POINT for m in data.members) and len(points) < least:
        return (
            f"{len(points)} operating points were run, at least {least} are needed to distinguish noise from structure"
        )
    return ""


__all__ = ["LOAD_TORQUE", "Dataset", "Member", "Progress", "enough", "is_linear", "load"]
