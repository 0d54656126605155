"""From a recording to the quantities the physics terms ask for: smoothed rates, direction, travel; then blocks of rows.

Rates come from a local polynomial over about a tenth of a second: one count of a 13-bit encoder at 2 kHz is 1.5 rad/s,
so differences of single samples say nothing. Single wild samples (spikes) are found against a running median and left
out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.mismatch.motion import USUAL, Manner, corners, directions, since_change
from bench.mismatch.smoothing import repaired, smooth, spikes
from bench.mismatch.thinning import Measured, Thinning, group_of
from bench.recording import Recording
from bench.simulation.frame import ARRAYS, FloatArray, Frame, IntArray

REFERENCE_TEMPERATURE = 25.0
"""°C, to which f_vT and the cooling of the nominal simulation are referred"""
NOTCH = (150.0, 300.0)
"""6 and 12 times the load motor's 25 pole pairs"""
MEASURED = ("transmission_error", "motor_torque", "temperature", "load_torque")


@dataclass(frozen=True, slots=True)
class Prepared:
    """One recording, at its own rate or in groups of samples (:mod:`bench.mismatch.thinning`).

    ``frame`` has a row a group; ``measured`` the compared channels in SI units (those the file has), with the number of
    valid samples in each group and their scatter inside it; ``label`` the number of each group's segment;
    ``sample_rate`` is that of the groups, Hz.
    """

    recording_id: str
    kind: str
    sample_rate: float
    frame: Frame
    thinning: Thinning
    measured: dict[str, Measured]
    swept: FloatArray
    """variance of the input angle inside each group, times its valid samples, rad²"""
    leaning: FloatArray
    """the same of input angle and transmission error together, rad²"""
    angle: FloatArray
    """input angle of every sample, rad at the output"""
    label: IntArray
    setpoint: tuple[float, float, float]
    corner: NDArray[np.bool_]
    """True where the acceleration jumps: rates smoothed over a corner say nothing about the moment itself"""
    dead: frozenset[str]
    """channels that hold no number at all: as good as missing"""


def ripple(
    q: FloatArray, torque: FloatArray, direction: FloatArray, bad: NDArray[np.bool_], orders: tuple[float, ...] = NOTCH
) -> FloatArray:
    """The load motor's torque ripple, fitted to a recording's load torque over the angle: the notch of the bench.

    At standstill it is a constant that cannot be told from the load and is left in.
    """
    moving = (direction != 0) & ~bad
    out = np.zeros(q.size)
    if moving.sum() < 200 or np.ptp(q[moving]) < 0.15:
        return out
    own, angle = torque[moving], q[moving]
    # the slow part is no ripple: a constant, the direction and a line over time stand beside it
    rows = [f(order * angle) for f in (np.cos, np.sin) for order in orders]
    rows += [np.ones(angle.size), direction[moving], np.linspace(-1.0, 1.0, q.size)[moving]]
    design = np.array(rows)
    off = np.abs(own - np.median(own))
    chosen = off <= np.percentile(off, 99)
    told = design[:, chosen]
    normal = told @ told.T
    normal[np.diag_indices_from(normal)] *= 1.0 + 1e-9
    beta = np.linalg.lstsq(normal, told @ own[chosen], rcond=1e-12)[0]
    out[moving] = beta[: 2 * len(orders)] @ design[: 2 * len(orders)]
    return out


def prepare(
    recording: Recording,
    index: int,
    campaign_start: float,
    travelled: float = 0.0,
    manner: Manner = USUAL,
) -> Prepared:
    """Read a recording and derive what the terms need.

    Parameters: ``index`` of the recording in the folder; ``campaign_start`` as a POSIX time; ``travelled`` the distance
    run before it in this campaign, rad at the output; ``manner`` how its motion is read. Raises
    RecordingError where the file cannot be read.
    """
    if recording.gearbox.ratio is None:
        raise RecordingError(f"{recording.path}: gearbox.ratio is missing; a linear axis has ratio 1")
    ratio = float(recording.gearbox.ratio)
    rate = float(recording.sample_rate)
    span = manner.smoothing
    thinning = Thinning(group_of(rate, span))
    time = thinning.mean(recording.si("time"))
    n = time.size
    bad: dict[str, NDArray[np.bool_]] = {}
    samples: dict[str, FloatArray] = {}

    def channel(name: str) -> FloatArray:
        if name not in recording:
            samples[name] = np.zeros(recording.size)
            return np.zeros(n)
        signal = recording.si(name)
        bad[name] = spikes(signal)
        samples[name] = repaired(signal, bad[name])
        return thinning.mean(samples[name])

    motor = channel("motor_angle")
    load = channel("load_angle")
    motor_torque = channel("motor_torque")
    load_torque = channel("load_torque")
    load_motor_torque = channel("load_motor_torque")
    # without a thermometer nothing can depend on temperature: the value at which the nominal terms are referred to
    temperature = channel("temperature") if "temperature" in recording else np.full(n, REFERENCE_TEMPERATURE)
    rate = rate / thinning.group
    theta = motor / ratio
    q = load if "load_angle" in recording else theta
    omega = smooth(motor, rate, 1, span) if "motor_angle" in recording else channel("motor_velocity")
    direction, last = directions(omega, manner.standstill)
    reversal_travel, reversal_time, reversed_before = since_change(theta, time, direction, last)
    label, steady = _segments(recording, thinning)
    notched: dict[str, FloatArray] = {}
    if "load_torque" in recording:
        wild = ~thinning.every(~bad["load_torque"])
        notched["load_torque"] = ripple(q, load_torque - load_motor_torque, direction, wild)
        load_torque = load_torque - notched["load_torque"]
    load_on_bench = load_torque if "load_torque" in recording else _second_best(recording, load_motor_torque)
    torque = smooth(load_on_bench, rate, 0, span)
    if "motor_torque" in recording and "load_torque" in recording:  # without it there is no load motor to ripple
        # the ripple acts on the gearbox, so the input motor sees it through the ratio
        wild = ~thinning.every(~bad["motor_torque"])
        notched["motor_torque"] = ripple(q, motor_torque - torque / ratio, direction, wild)
        motor_torque = motor_torque - notched["motor_torque"]
    frame = Frame(
        ratio=ratio,
        recording=np.full(n, index, dtype=np.int64),
        count=np.full(n, float(thinning.group)),
        time=time + (recording.started_at.timestamp() - campaign_start),
        elapsed=time,
        theta=theta,
        q=q,
        velocity=omega / ratio,
        acceleration=smooth(motor, rate, 2, span) if "motor_angle" in recording else smooth(omega, rate, 1, span),
        load_acceleration=smooth(q, rate, 2, span),
        direction=direction,
        last_direction=last,
        torque=torque,
        torque_rate=smooth(load_torque, rate, 1, span),
        temperature=repaired(temperature, ~np.isfinite(temperature)),
        motor_torque=motor_torque,
        load_motor_torque=load_motor_torque,
        power=np.abs(smooth(motor_torque, rate, 0, span) * omega - torque * smooth(q, rate, 1, span)),
        travel=travelled + np.cumsum(np.abs(np.diff(theta, prepend=theta[0]))),
        reversal_travel=reversal_travel,
        reversal_time=reversal_time,
        reversed_before=reversed_before,
        steady=steady,
        step=np.diff(time, prepend=time[0]),
    )
    measured: dict[str, Measured] = {}
    angle = samples["motor_angle"] / ratio
    swept = leaning = np.zeros(n)
    if "motor_angle" in recording and "load_angle" in recording:
        error = samples["load_angle"] - angle
        good = ~(bad["motor_angle"] | bad["load_angle"] | spikes(error))
        measured["transmission_error"] = thinning.measured(error, good)
        swept, leaning = thinning.inner(angle, angle, good), thinning.inner(angle, error, good)
    corner = corners(frame.acceleration, rate, span)
    for name in ("motor_torque", "temperature", "load_torque"):
        if name in recording:
            own = thinning.measured(samples[name], ~bad[name])
            measured[name] = own.less(notched.get(name), thinning).without(corner if name != "temperature" else None)
    setpoint = recording.setpoint
    return Prepared(
        recording.recording_id,
        recording.kind,
        rate,
        frame,
        thinning,
        measured,
        swept,
        leaning,
        angle,
        label,
        (setpoint.load_torque, setpoint.velocity, setpoint.temperature),
        corner,
        frozenset(name for name, marked in bad.items() if marked.all()),
    )


def _segments(recording: Recording, thinning: Thinning) -> tuple[IntArray, FloatArray]:
    """Number of the segment of each group's first sample (-1: none); and 1 where all its samples are steady."""
    label = np.full(recording.size, -1, dtype=np.int64)
    steady = np.zeros(recording.size, dtype=bool)
    for number, segment in enumerate(recording.segments):
        label[segment.start : segment.stop] = number
        steady[segment.start : segment.stop] |= segment.name == "steady"
    return thinning.first(label), thinning.every(steady).astype(np.float64)


def _second_best(recording: Recording, load_motor_torque: FloatArray) -> FloatArray:
    """The load on a bench without torque sensor: what the load motor reports, or else what was asked for."""
    if "load_motor_torque" in recording:
        return load_motor_torque
    asked = recording.setpoint.load_torque
    return np.full(load_motor_torque.size, asked if np.isfinite(asked) else 0.0)


def block_edges(prepared: Prepared, coarse_s: float = 0.1, fine_s: float = 0.02) -> IntArray:
    """Start indices of blocks: short where direction or speed change, longer in steady motion, never across a segment's
    end.
    """
    frame, rate = prepared.frame, prepared.sample_rate
    lively = (frame.reversal_time < 1.5) & (frame.reversal_travel < 0.05)
    width = np.where(lively, max(1.0, round(fine_s * rate)), max(1.0, round(coarse_s * rate)))
    number = np.floor(np.cumsum(1.0 / width) - 1.0 / width)
    change = np.diff(number) != 0
    change |= np.diff(prepared.label) != 0
    change |= np.diff(frame.direction) != 0
    change |= np.diff(prepared.corner) != 0
    return np.concatenate(([0], np.flatnonzero(change) + 1)).astype(np.int64)


def reduce(frame: Frame, edges: IntArray) -> Frame:
    """Average a frame over blocks; counts add up, the steps too."""
    count = np.add.reduceat(frame.count, edges)
    out: dict[str, Any] = {}
    for name in ARRAYS:
        values = getattr(frame, name)
        if name == "recording":
            out[name] = values[edges]
        elif name in ("count", "step"):
            out[name] = np.add.reduceat(values, edges)
        elif name in ("direction", "last_direction", "steady", "reversed_before"):
            out[name] = values[edges]
        else:
            out[name] = np.add.reduceat(values * frame.count, edges) / count
    return replace(frame, **out)


def block_mean(signal: FloatArray, number_of: FloatArray, edges: IntArray) -> tuple[FloatArray, FloatArray]:
    """Mean over the valid samples of each block, of which each row has ``number_of``, and how many they are (0 where
    none is valid).
    """
    number = np.add.reduceat(number_of, edges)
    total = np.add.reduceat(signal * number_of, edges)
    return total / np.maximum(number, 1.0), number
