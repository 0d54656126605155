"""A folder of recordings as rows to compare: read once, reduced to blocks, split by operating point.

Three reductions of the same recordings: slow rows (a quarter of a second, finer after reversals) for the torques and
the offset of the transmission error; angle rows (some 5,000 a revolution, finer than any order of the simulation) for
its harmonics; and rows of two seconds for the heat balance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.mismatch.motor_ripple import ShaftSpectrum, shaft_spectrum
from bench.mismatch.prepare import MEASURED, Prepared, block_edges, block_mean, prepare, reduce
from bench.mismatch.rows import Rows, join
from bench.recording import Recording, RecordingFolder
from bench.simulation.frame import FloatArray, IntArray

SLOW_S = 0.25
LIVELY_S = 0.02
HEAT_S = 2.0
ANGLE_STEP = 1.2e-3
ANGLE_STEP_S = 0.1
HELD_OUT_SHARE = 0.2
FEWEST_OF_A_KIND = 6
"""kinds with fewer recordings (heatings, reversals, ramps) all train: each of them is too telling to be spared"""
HELD_OUT_BESIDE_VALIDATION = 0.1
THERMAL_KINDS = ("heating", "cooling", "dwell")


@dataclass(frozen=True, slots=True)
class Member:
    """One recording of the data set."""

    index: int
    recording: Recording
    point: tuple[str, float, float, float]
    held_out: bool
    fold: int
    zero: str | None = None


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
    campaign_start: float = 0.0
    notes: list[str] = field(default_factory=list)

    @property
    def ratio(self) -> float:
        """Gear ratio u of the recordings."""
        return float(self.members[0].recording.gearbox.ratio or 1.0)

    def held_out(self) -> set[int]:
        """Indices of the recordings that are scored and never fitted."""
        return {m.index for m in self.members if m.held_out}


def _point(recording: Recording) -> tuple[str, float, float, float]:
    setpoint = recording.setpoint
    clean = [v if np.isfinite(v) else 0.0 for v in (setpoint.load_torque, setpoint.velocity, setpoint.temperature)]
    return recording.kind, round(clean[0], 0), round(clean[1], 4), round(clean[2] / 4.0)


def split(recordings: Sequence[Recording]) -> tuple[list[bool], list[int]]:
    """Choose held-out recordings by whole operating points, and a fold for each of the others.

    Validation points are always held out. Of the other kinds a fifth of the points is (a tenth of
    the constant-velocity points where there are five validation points or more), spread evenly, never the outermost of
    a kind with few points, and none of a kind that has fewer than six recordings.
    """
    points = [_point(r) for r in recordings]
    held: list[bool] = [r.kind == "validation" for r in recordings]
    validation = sum(held)
    if all(held):
        held = [i % 3 == 1 for i in range(len(held))]
    kinds: dict[str, list[tuple[str, float, float, float]]] = {}
    for i, point in enumerate(points):
        if not held[i] and point not in kinds.setdefault(point[0], []):
            kinds[point[0]].append(point)
    chosen: set[tuple[str, float, float, float]] = set()
    for kind, members in kinds.items():
        count = sum(1 for i, p in enumerate(points) if p[0] == kind and not held[i])
        if count < FEWEST_OF_A_KIND or len(members) < 3:
            continue
        # repeats of a point tell the noise: points with repeats stay in training
        single = [p for p in members if sum(q == p for q in points) == 1 or len(members) < 6]
        enough = kind == "constant_velocity" and validation >= 5
        share = HELD_OUT_BESIDE_VALIDATION if enough else HELD_OUT_SHARE
        number = max(1, round(share * len(members)))
        order = _spread(single, number)
        chosen.update(order)
    held = [h or points[i] in chosen for i, h in enumerate(held)]
    folds: dict[tuple[str, float, float, float], int] = {}
    fold = [folds.setdefault(points[i], len(folds)) if not held[i] else -1 for i in range(len(points))]
    return held, fold


def _spread(members: Sequence[tuple[str, float, float, float]], number: int) -> list[tuple[str, float, float, float]]:
    """A number of points, evenly along the campaign but inside the bounds of torque and speed where possible."""
    torque = [abs(p[1]) for p in members]
    speed = [abs(p[2]) for p in members]
    inner = [
        p
        for p, t, v in zip(members, torque, speed, strict=True)
        if not (t >= 0.99 * max(torque) and v in (max(speed), min(speed)))
    ]
    pool = inner if len(inner) >= number + 2 else list(members)
    step = len(pool) / number
    return [pool[int((i + 0.5) * step)] for i in range(number)]


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
    held, fold = split(usable)
    data = Dataset([], rejected, campaign_start=usable[0].started_at.timestamp())
    zeros = {r.zero_id for r in usable if r.zero_id is not None}
    if len(zeros) > 1:
        data.notes.append(f"recordings of {len(zeros)} different encoder zeros are mixed: offsets and phases may jump")
    slow: dict[str, list[Rows]] = {}
    heat: list[Rows] = []
    angle: list[Rows] = []
    travelled = 0.0
    for number, recording in enumerate(usable):
        if progress is not None:
            progress("reading", number / len(usable))
        try:
            prepared = prepare(recording, number, data.campaign_start, travelled)
        except (RecordingError, OSError, ValueError) as error:
            rejected.append((recording.path.name, f"{recording.path.name} cannot be read: {error}"))
            continue
        travelled = float(prepared.frame.travel[-1])
        data.members.append(Member(number, recording, _point(recording), held[number], fold[number], recording.zero_id))
        edges = block_edges(prepared, SLOW_S, LIVELY_S)
        for channel in MEASURED:
            if channel in prepared.measured and channel != "temperature":
                slow.setdefault(channel, []).append(_rows(prepared, edges, channel))
        if "motor_torque" in prepared.measured:
            inner = _inside(prepared, "motor_torque", edges)
            spectrum = shaft_spectrum(prepared, inner, prepared.valid["motor_torque"])
            if spectrum is not None:
                data.shaft.append(spectrum)
        if "temperature" in prepared.measured:
            width = max(1, round(HEAT_S * prepared.sample_rate))
            heat.append(_rows(prepared, np.arange(0, prepared.frame.size, width), "temperature"))
        if "transmission_error" in prepared.measured and recording.kind != "heating":
            angle.append(_angle_rows(prepared))
    if not data.members:
        raise RecordingError(f"{path} holds no recording that can be read; see `bench validate` for each file")
    data.slow = {channel: join(parts) for channel, parts in slow.items()}
    data.heat = join(heat) if heat else None
    data.angle = join(angle) if angle else None
    return data
