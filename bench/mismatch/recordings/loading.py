"""A folder of recordings, or several as one, read into a data set: each recording once, on several processes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby

from bench.errors import RecordingError
from bench.foreign.base import Base
from bench.mismatch.mapping import over
from bench.mismatch.memory import give_back
from bench.mismatch.recordings.collected import Collected
from bench.mismatch.recordings.comparable import Comparable
from bench.mismatch.recordings.dataset import Dataset, Member, is_linear
from bench.mismatch.recordings.extrapolated import fitted_too
from bench.mismatch.recordings.faulty import Faulty, nowhere_measured, of_other_sign
from bench.mismatch.recordings.followed_waves import NOTE, follows_waves
from bench.mismatch.recordings.motion import slowly
from bench.mismatch.recordings.pieces import Piece, pieces
from bench.mismatch.recordings.prepared import Folder, prepare
from bench.mismatch.recordings.repeated_motion import repeats
from bench.mismatch.recordings.resolution import unresolved
from bench.mismatch.recordings.source import Paths, folders_of, gathered, names_of, of_one_campaign
from bench.mismatch.recordings.split import load_step, none_spared, point_of, split, split_blocks
from bench.recording import Recording
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TRANSMISSION_ERROR

Progress = Callable[[str, float], None]
SAMPLES_A_PROCESS = 8_000_000
"""a process takes seconds to start: it is worth that for some million samples only"""
LEAST_SAMPLES = 50


def load(
    path: Paths,
    progress: Progress | None = None,
    jobs: int = 1,
    base: Base | None = None,
    waves: bool | None = None,
    span: float | None = None,
) -> Dataset:
    """Read a folder of recordings, or several as one, and reduce it, on ``jobs`` processes; ``base``: a simulation from
    elsewhere; ``waves``: whether the load torque follows those of the transmission error, and ``span``: over how many
    seconds rates of a motion without set speeds are smoothed, where that is known.

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
    usable = _of_one_campaign(usable, rejected)
    usable = _of_one_gearbox(usable, rejected)
    usable = _of_one_sign(usable, rejected)
    held, fold = split(usable)
    fitted = [r for r, out in zip(usable, held, strict=True) if not out]
    parts, note = pieces(usable, len(fitted))
    called = {str(r.path): name for r, name in zip(usable, names_of(usable), strict=True)}
    if note:
        held, fold = split_blocks(parts)
    notes = [note] if note else []
    if not any(held):
        notes.append(none_spared(usable))
    step = load_step(usable)
    comparable = Comparable.of(usable, notes)
    if nowhere_measured(usable):
        comparable = replace(comparable, present=comparable.present - {"temperature"})
        notes.append("the thermometer is open or shorted in all recordings: nothing is compared with the temperature")
    if all(is_linear(r) for r in usable):
        notes.append("a linear axis: metres and newtons")
    folder = Folder.of(usable, base).smoothed(span)
    if waves is None:
        waves = follows_waves(fitted, folder)
    if not waves:
        folder = folder.following(waves)
        notes.append(NOTE)
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
            data.members.append(Member(number, recording, point_of(recording, step), held[number], fold[number], title))
        notes += [
            f"{recording.recording_id}: {name} {what.does}, {what.share:.2g} of the samples: not compared there"
            for name, what in read.faulty.items()
            if name in comparable.present
        ]
        dead = sorted(read.dead & comparable.present - read.faulty.keys())
        if dead:
            text = f"{recording.recording_id} holds no number in {', '.join(dead)}"
            notes.append(f"{text}: not compared where it is needed")
    if not data.members:
        if base is not None and rejected:
            raise RecordingError(rejected[0][1])
        raise RecordingError(f"{_named(path)} holds no recording that can be read; see `bench validate` for each file")
    for channel in list(rows.rows):
        data.rows[channel] = rows.joined(channel)
        del rows.rows[channel]
    compared = next((name for name in (TRANSMISSION_ERROR, MOTOR_TORQUE, *data.rows) if name in data.rows), None)
    if compared is not None and not note:
        data.members, beyond = fitted_too(data.members, data.rows[compared].frame)
        if beyond:
            notes.append(
                "validation points that lie farther from the fitted recordings, in the polynomials of load, speed and"
                f" temperature, than any of these does: fitted and not held out: {', '.join(beyond)}"
            )
    if LOAD_TORQUE in data.rows:
        data.unresolved = unresolved([m.recording for m in data.members], "load_motor_torque")
    if MOTOR_TORQUE in data.rows:
        notes += slowly(data.rows[MOTOR_TORQUE].frame, folder.manner)
        if folder.manner.free:
            notes += repeats(data.rows[MOTOR_TORQUE].frame, data.held_out())
    give_back()
    data.density, data.unsteady = rows.density, rows.unsteady
    data.shaft, data.output, data.swing = rows.shaft, rows.output, rows.swing
    return data


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


def _of_one_campaign(recordings: list[Recording], rejected: list[tuple[str, str]]) -> list[Recording]:
    """The recordings of one campaign; those whose clock was not set are rejected."""
    out = of_one_campaign(recordings)
    for recording in recordings:
        if recording not in out:
            why = (
                f"{recording.path.name} says it was started on {recording.started_at.date()}, years from most of the"
                f" folder ({out[0].started_at.date()}): was the clock set? With the right started_at it is compared"
            )
            rejected.append((recording.path.name, why))
    return out


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
    faulty: Mapping[str, Faulty] = field(default_factory=dict)


def _read(task: _Task) -> _Read:
    recording = task.pieces[0][1].recording
    rows = Collected()
    try:
        prepared = prepare(recording, task.pieces[0][0], task.folder)
    except (RecordingError, OSError, ValueError) as error:
        name, text = recording.path.name, str(error)
        return _Read(rows, why=text if text.startswith(name) else f"{name} cannot be read: {text}")
    channels = task.comparable.channels(recording, prepared.dead)
    for number, part in task.pieces:
        rows.add(part.cut(prepared, number), channels, task.folder.manner)
    travel, simulated = float(prepared.frame.travel[-1]), frozenset(prepared.simulated)
    return _Read(rows, travel, prepared.dead, "", simulated, prepared.faulty)


def _otherwise(recording: Recording, here: frozenset[str], others: frozenset[str]) -> str:
    listed, rest = (", ".join(sorted(names)) or "nothing" for names in (here, others))
    return f"{recording.path.name}: the simulation predicts {listed} of it, of the recordings before it {rest}"


def _of_one_sign(recordings: list[Recording], rejected: list[tuple[str, str]]) -> list[Recording]:
    """The recordings whose load torque has the sign of most; the others are rejected."""
    other = of_other_sign(recordings)
    for recording in other:
        why = (
            f"{recording.path.name}: its load torque has the other sign beside the load motor's torque than in most of"
            " the folder: was the sensor's sign changed? With the right sign it is compared"
        )
        rejected.append((recording.path.name, why))
    return [r for r in recordings if r not in other]


def _of_one_gearbox(recordings: list[Recording], rejected: list[tuple[str, str]]) -> list[Recording]:
    """The recordings of the ratio that most have; the others are rejected."""
    ratios = [float(r.gearbox.ratio or 1.0) for r in recordings]
    usual = max(set(ratios), key=ratios.count)
    for recording, ratio in zip(recordings, ratios, strict=True):
        if ratio != usual:
            why = f"is of a gearbox of ratio {ratio:g}, most of the folder of {usual:g}: not one bench"
            rejected.append((recording.path.name, f"{recording.path.name} {why}"))
    return [r for r, ratio in zip(recordings, ratios, strict=True) if ratio == usual]
