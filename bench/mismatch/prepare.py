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
from bench.recording import Recording
from bench.simulation.frame import ARRAYS, FloatArray, Frame, IntArray

REFERENCE_TEMPERATURE = 25.0
"""°C, to which f_vT and the cooling of the nominal simulation are referred"""
NOTCH = (150.0, 300.0)
"""6 and 12 times the load motor's 25 pole pairs"""
MEASURED = ("transmission_error", "motor_torque", "temperature", "load_torque")


@dataclass(frozen=True, slots=True)
class Prepared:
    """One recording at its own rate.

    ``frame`` has a row a sample; ``measured`` the compared channels in SI units (those the file has); ``valid`` is
    False where a sample of that channel is a spike or not a number; ``segments`` names the segment of each sample
    (index into ``names``).
    """

    recording_id: str
    kind: str
    sample_rate: float
    frame: Frame
    measured: dict[str, FloatArray]
    valid: dict[str, NDArray[np.bool_]]
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
    angle = q[:, None] * np.asarray(orders)[None, :]
    waves = np.hstack([np.cos(angle), np.sin(angle)])
    # the slow part is no ripple: a constant, the direction and a line over time stand beside it
    slow = np.column_stack([np.ones(q.size), direction, np.linspace(-1.0, 1.0, q.size)])
    design = np.hstack([waves, slow])[moving]
    limit = np.percentile(np.abs(torque[moving] - np.median(torque[moving])), 99)
    chosen = np.abs(torque[moving] - np.median(torque[moving])) <= limit
    normal = design[chosen].T @ design[chosen]
    normal[np.diag_indices_from(normal)] *= 1.0 + 1e-9
    beta = np.linalg.lstsq(normal, design[chosen].T @ torque[moving][chosen], rcond=1e-12)[0]
    out[moving] = waves[moving] @ beta[: waves.shape[1]]
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
    n = recording.size
    time = recording.si("time")
    absent = np.zeros(n)
    bad: dict[str, NDArray[np.bool_]] = {}

    def channel(name: str, screen: bool = True) -> FloatArray:
        if name not in recording:
            return absent
        signal = recording.si(name)
        bad[name] = spikes(signal) if screen else ~np.isfinite(signal)
        return repaired(signal, bad[name])

    motor = channel("motor_angle")
    load = channel("load_angle")
    motor_torque = channel("motor_torque")
    load_torque = channel("load_torque")
    load_motor_torque = channel("load_motor_torque")
    # without a thermometer nothing can depend on temperature: the value at which the nominal terms are referred to
    temperature = channel("temperature") if "temperature" in recording else np.full(n, REFERENCE_TEMPERATURE)
    theta = motor / ratio
    q = load if "load_angle" in recording else theta
    omega = smooth(motor, rate, 1, span) if "motor_angle" in recording else channel("motor_velocity")
    direction, last = directions(omega, manner.standstill)
    reversal_travel, reversal_time, reversed_before = since_change(theta, time, direction, last)
    label = np.full(n, -1, dtype=np.int64)
    steady = np.zeros(n)
    for number, segment in enumerate(recording.segments):
        label[segment.start : segment.stop] = number
        if segment.name == "steady":
            steady[segment.start : segment.stop] = 1.0
    if "load_torque" in recording:
        load_torque = load_torque - ripple(q, load_torque - load_motor_torque, direction, bad["load_torque"])
    torque = smooth(load_torque, rate, 0, span)
    if "motor_torque" in recording and "load_torque" in recording:  # without it there is no load motor to ripple
        # the ripple acts on the gearbox, so the input motor sees it through the ratio
        motor_torque = motor_torque - ripple(q, motor_torque - torque / ratio, direction, bad["motor_torque"])
    frame = Frame(
        ratio=ratio,
        recording=np.full(n, index, dtype=np.int64),
        count=np.ones(n),
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
    measured: dict[str, FloatArray] = {}
    valid: dict[str, NDArray[np.bool_]] = {}
    if "motor_angle" in recording and "load_angle" in recording:
        error = q - theta
        measured["transmission_error"] = error
        valid["transmission_error"] = ~(bad["motor_angle"] | bad["load_angle"] | spikes(error))
    for name, signal in (("motor_torque", motor_torque), ("temperature", temperature), ("load_torque", load_torque)):
        if name in recording:
            measured[name] = signal
            valid[name] = ~bad[name]
    corner = corners(frame.acceleration, rate, span)
    for name in ("motor_torque", "load_torque"):
        if name in valid:
            valid[name] = valid[name] & ~corner
    setpoint = recording.setpoint
    return Prepared(
        recording.recording_id,
        recording.kind,
        rate,
        frame,
        measured,
        valid,
        label,
        (setpoint.load_torque, setpoint.velocity, setpoint.temperature),
        corner,
        frozenset(name for name, marked in bad.items() if marked.all()),
    )


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


def block_mean(signal: FloatArray, valid: NDArray[np.bool_], edges: IntArray) -> tuple[FloatArray, FloatArray]:
    """Mean over the valid samples of each block, and their number (0 where none is valid)."""
    weight = valid.astype(np.float64)
    number = np.add.reduceat(weight, edges)
    total = np.add.reduceat(np.where(valid, signal, 0.0), edges)
    return total / np.maximum(number, 1.0), number
