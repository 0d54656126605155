"""A folder of recordings as rows to compare: read once, reduced to blocks, split by operating point.

Three reductions of the same recordings: slow rows (a quarter of a second, finer after reversals) for the torques and
the offset of the transmission error; angle rows (some 5,000 a revolution, finer than any order of the simulation) for
its harmonics; and rows of two seconds for the heat balance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.mismatch.comparable import Comparable
from bench.mismatch.motion import Manner
from bench.mismatch.motor_ripple import ShaftSpectrum, shaft_spectrum
from bench.mismatch.pieces import pieces
from bench.mismatch.prepare import MEASURED, Prepared, block_edges, block_mean, prepare, reduce
from bench.mismatch.rows import Rows, join
from bench.mismatch.split import point_of, split, split_blocks
from bench.mismatch.tones import ToneSpectrum, tone_spectrum
from bench.recording import Recording, RecordingFolder
from bench.simulation.frame import FloatArray, IntArray

SLOW_S = 0.25
LIVELY_S = 0.02
HEAT_S = 2.0
ANGLE_STEP = 1.2e-3
ANGLE_STEP_S = 0.1
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


def _rows(prepared: Prepared, edges: IntArray, channel: str) -> Rows:
    signal, valid = prepared.measured[channel], prepared.valid[channel]
    mean, number = block_mean(signal, valid, edges)
    square = np.add.reduceat(_inside(prepared, channel, edges) ** 2, edges)
    return Rows(reduce(prepared.frame, edges), mean, number, square / np.maximum(number - 1.0, 1.0))


def _angle_rows(prepared: Prepared) -> Rows:
    """Rows over the angle, with how the samples inside a row follow the angle: fast orders move within a row."""
    edges = _angle_edges(prepared)
    rows = _rows(prepared, edges, "transmission_error")
    valid = prepared.valid["transmission_error"]
    inner = _inside(prepared, "transmission_error", edges)
    width = np.diff(np.append(edges, valid.size))
    angle, _ = block_mean(prepared.frame.theta, valid, edges)
    turned = np.where(valid, prepared.frame.theta - np.repeat(angle, width), 0.0)
    number = np.maximum(rows.number, 1.0)
    return replace(
        rows, lean=np.add.reduceat(inner * turned, edges) / number, sweep=np.add.reduceat(turned**2, edges) / number
    )


def _inside(prepared: Prepared, channel: str, edges: IntArray) -> FloatArray:
    """The samples' deviations from their block's mean that the simulation does not explain; 0 where not valid."""
    signal, valid = prepared.measured[channel], prepared.valid[channel]
    mean, _ = block_mean(signal, valid, edges)
    width = np.diff(np.append(edges, signal.size))
    inner = np.where(valid, signal - np.repeat(mean, width), 0.0)
    return np.where(valid, inner - _explained_inside(prepared, channel, inner, valid, edges, width), 0.0)


def _explained_inside(
    prepared: Prepared,
    channel: str,
    inner: FloatArray,
    valid: NDArray[np.bool_],
    edges: IntArray,
    width: IntArray,
) -> FloatArray:
    """What the simulation's own quantities explain of the samples' deviations from their block's mean.

    A speed that wavers faster than a block accelerates the inertia: that is no noise.
    """
    names = {
        "motor_torque": ("acceleration", "torque", "velocity"),
        "load_torque": ("load_acceleration", "load_motor_torque"),
        "transmission_error": ("torque", "velocity"),
    }.get(channel, ())
    if not names:
        return np.zeros(inner.size)
    parts = []
    for name in names:
        values = getattr(prepared.frame, name)
        average = np.add.reduceat(values, edges) / width
        parts.append(values - np.repeat(average, width))
    design = np.column_stack(parts)
    scale = np.maximum(np.sqrt(np.mean(design**2, axis=0)), 1e-30)
    chosen = valid & (np.abs(inner) < 6.0 * max(float(np.std(inner[valid])) if valid.any() else 1.0, 1e-30))
    lhs = design[chosen] / scale
    normal = lhs.T @ lhs + 1e-6 * max(float(chosen.sum()), 1.0) * np.eye(len(names))
    return np.asarray(design / scale @ np.linalg.solve(normal, lhs.T @ inner[chosen]))


def _angle_edges(prepared: Prepared) -> IntArray:
    frame = prepared.frame
    smooth = np.abs(frame.velocity) / prepared.sample_rate / ANGLE_STEP
    number = np.floor(np.cumsum(np.maximum(smooth, 1.0 / (ANGLE_STEP_S * prepared.sample_rate))))
    change = np.diff(number) != 0
    change |= np.diff(prepared.label) != 0
    change |= np.diff(frame.direction) != 0
    return np.concatenate(([0], np.flatnonzero(change) + 1)).astype(np.int64)


def _usable(recording: Recording) -> str | None:
    if recording.size < 50:
        return f"{recording.path.name} has {recording.size} samples; at least 50 are needed to say anything"
    if recording.gearbox.ratio is None:
        return f"{recording.path.name} names no gear ratio (gearbox/ratio); without it no angle can be compared"
    if not any(name in recording for name in ("load_angle", "motor_torque", "load_torque", "temperature")):
        return f"{recording.path.name} has none of the channels that are compared"
    return None


def load(path: Path, progress: Callable[[str, float], None] | None = None) -> Dataset:
    """Read a folder of recordings (or a list in a manifest's folder) and reduce it.

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
    rows = _Collected()
    travelled = 0.0
    last: tuple[Recording, Prepared] | None = None
    for number, part in enumerate(parts):
        recording = part.recording
        if progress is not None:
            progress("reading", number / len(parts))
        try:
            if last is None or last[0] is not recording:
                last = recording, prepare(recording, number, data.campaign_start, travelled, manner)
        except (RecordingError, OSError, ValueError) as error:
            rejected.append((recording.path.name, f"{recording.path.name} cannot be read: {error}"))
            continue
        prepared = part.cut(last[1], number)
        travelled = float(prepared.frame.travel[-1])
        data.members.append(
            Member(number, recording, point_of(recording), held[number], fold[number], recording.zero_id, part.name)
        )
        rows.add(prepared, comparable.channels(recording, prepared.dead))
        if prepared.dead:
            told = f"{part.name} holds no number in {', '.join(sorted(prepared.dead))}: not compared where it is needed"
            data.notes.append(told)
    if not data.members:
        raise RecordingError(f"{path} holds no recording that can be read; see `bench validate` for each file")
    rows.into(data)
    return data


@dataclass(slots=True)
class _Collected:
    """Rows of the recordings read so far."""

    slow: dict[str, list[Rows]] = field(default_factory=dict)
    heat: list[Rows] = field(default_factory=list)
    angle: list[Rows] = field(default_factory=list)
    shaft: list[ShaftSpectrum] = field(default_factory=list)
    tones: dict[str, list[ToneSpectrum]] = field(default_factory=dict)

    def add(self, prepared: Prepared, channels: frozenset[str]) -> None:
        """Reduce a recording to rows of the channels in which it can be compared."""
        edges = block_edges(prepared, SLOW_S, LIVELY_S)
        for channel in channels & set(prepared.measured) - {"temperature"}:
            self.slow.setdefault(channel, []).append(_rows(prepared, edges, channel))
            self._listen(prepared, channel)
        if "motor_torque" in channels and "motor_torque" in prepared.measured:
            inner = _inside(prepared, "motor_torque", edges)
            spectrum = shaft_spectrum(prepared, inner, prepared.valid["motor_torque"])
            if spectrum is not None:
                self.shaft.append(spectrum)
        if "temperature" in channels and "temperature" in prepared.measured:
            width = max(1, round(HEAT_S * prepared.sample_rate))
            self.heat.append(_rows(prepared, np.arange(0, prepared.frame.size, width), "temperature"))
        driven = prepared.kind != "heating"
        if "transmission_error" in channels and "transmission_error" in prepared.measured and driven:
            self.angle.append(_angle_rows(prepared))

    def into(self, data: Dataset) -> None:
        """Join the rows of all recordings."""
        data.slow = {channel: join(self.slow[channel]) for channel in MEASURED if channel in self.slow}
        data.heat = join(self.heat) if self.heat else None
        data.angle = join(self.angle) if self.angle else None
        data.shaft = self.shaft
        data.tones = self.tones

    def _listen(self, prepared: Prepared, channel: str) -> None:
        frame = prepared.frame
        index = int(frame.recording[0])
        steady = (frame.steady > 0.5) & (frame.direction != 0)
        heard = tone_spectrum(
            index, prepared.measured[channel], prepared.valid[channel], steady, prepared.sample_rate, frame.velocity
        )
        if heard is not None:
            self.tones.setdefault(channel, []).append(heard)


def _of_one_gearbox(recordings: list[Recording], rejected: list[tuple[str, str]]) -> list[Recording]:
    """The recordings of the ratio that most have; the others are rejected."""
    ratios = [float(r.gearbox.ratio or 1.0) for r in recordings]
    usual = max(set(ratios), key=ratios.count)
    for recording, ratio in zip(recordings, ratios, strict=True):
        if ratio != usual:
            why = f"is of a gearbox of ratio {ratio:g}, most of the folder of {usual:g}: not one bench"
            rejected.append((recording.path.name, f"{recording.path.name} {why}"))
    return [r for r, ratio in zip(recordings, ratios, strict=True) if ratio == usual]
