"""Points that a bench could run next, as rows of ideal motion: what each explanation would predict there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from bench.mismatch.dataset import Dataset
from bench.simulation.frame import FloatArray, Frame

STEP_S = 0.25
RAMP_TORQUE_N_M_S = 500.0
REVERSALS_RAD = (np.radians(2.0), np.radians(10.0), np.radians(40.0))
CYCLES, STEPS, HOLD_S = 3, 5, 2.0
_CORNER_S = 0.5
"""how long a reversal takes"""
LATER_S = 1800.0
"""when a campaign made of the proposal begins, after the last recording"""


@dataclass(frozen=True, slots=True)
class Range:
    """What the recordings have covered: torque up to ``torque`` N·m, output speeds rad/s, temperatures °C, and the end
    of the campaign (s) and its travel (rad).
    """

    torque: float
    slowest: float
    fastest: float
    coldest: float
    warmest: float
    end: float
    travel: float

    @classmethod
    def of(cls, data: Dataset) -> Range:
        """Read the range from the setpoints and the recordings themselves; heating speeds are no operating points."""
        setpoints = [(m.recording.kind, m.recording.setpoint) for m in data.members]
        torque = [abs(s.load_torque) for _, s in setpoints if np.isfinite(s.load_torque)]
        speed = [
            abs(s.velocity)
            for kind, s in setpoints
            if np.isfinite(s.velocity) and s.velocity != 0.0 and kind not in ("heating", "cooling", "dwell")
        ]
        frames = [rows.frame for rows in (*data.slow.values(), data.heat) if rows is not None]
        known = [f.temperature for f in frames if np.ptp(f.temperature) > 0.0]
        temperature = np.concatenate(known) if known else np.array([25.0])
        return cls(
            float(np.floor(max(torque, default=0.0))),
            min(speed, default=0.05),
            max(speed, default=0.1),
            float(np.percentile(temperature, 2)),
            float(np.percentile(temperature, 98)),
            max((float(f.time.max()) for f in frames), default=0.0),
            max((float(f.travel.max()) for f in frames), default=0.0),
        )


@dataclass(frozen=True, slots=True)
class Candidate:
    """A point of a campaign: sequence, torque N·m, velocity rad/s (signed), temperature °C (None: as found), options as
    they stand in a campaign file.
    """

    sequence: str
    torque: float
    velocity: float
    temperature: float | None = None
    options: tuple[tuple[str, str], ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The point as the report has it."""
        out = {"kind": self.sequence, "load_torque": self.torque, "velocity": self.velocity}
        return out if self.temperature is None else out | {"temperature": self.temperature}


def candidates(covered: Range) -> Iterator[Candidate]:
    """Admissible points: within the torques, speeds and temperatures that the bench has run, and slower."""
    warm = round(covered.warmest) if covered.warmest - covered.coldest > 6.0 else None
    temperatures = (None,) if warm is None else (None, float(warm))
    torques = tuple(dict.fromkeys(round(share * covered.torque) for share in (0.0, 0.1, 0.3, -0.3, 1.0, -1.0)))
    speeds = tuple(covered.fastest * share for share in (0.05, 0.15, 0.4, 1.0))
    for temperature in temperatures:
        for torque in torques:
            for speed in speeds:
                for side in (1.0, -1.0):
                    yield Candidate("constant_velocity", float(torque), side * speed, temperature)
        for preload in (0.0, 0.3 * covered.torque):
            for amplitude in REVERSALS_RAD:
                told = (("amplitude", f'"{np.degrees(amplitude):g} deg"'), ("cycles", f"{CYCLES}"))
                yield Candidate("reversal", float(round(preload)), 0.3 * covered.fastest, temperature, told)
        if covered.torque > 0.0:
            told = (("steps", f"{STEPS}"), ("hold", f'"{HOLD_S:g} s"'))
            yield Candidate("torque_ramp", covered.torque, 0.5 * covered.fastest, temperature, told)
        yield Candidate("velocity_ramp", 0.0, covered.fastest, temperature, (("duration", '"30 s"'),))


def frame_of(candidate: Candidate, covered: Range, ratio: float) -> Frame:
    """Rows of the candidate's ideal motion, a quarter of a second each; steady but for its changes."""
    velocity, torque, steady = _course(candidate)
    n = velocity.size
    time = STEP_S * np.arange(n)
    theta = np.cumsum(velocity) * STEP_S
    temperature = covered.coldest if candidate.temperature is None else candidate.temperature
    direction = np.sign(velocity)
    turned = np.concatenate(([False], direction[1:] * direction[:-1] < 0))
    start = np.maximum.accumulate(np.where(turned, np.arange(n), 0))
    way = np.cumsum(np.abs(velocity)) * STEP_S
    values: dict[str, Any] = {
        "count": 1.0,
        "time": covered.end + LATER_S + time,
        "elapsed": time,
        "theta": theta,
        "q": theta,
        "velocity": velocity,
        "acceleration": np.gradient(velocity, STEP_S) * ratio if n > 1 else 0.0,
        "direction": direction,
        "last_direction": np.where(direction != 0, direction, 1.0),
        "torque": torque,
        "torque_rate": np.gradient(torque, STEP_S) if n > 1 else 0.0,
        "temperature": temperature,
        "load_motor_torque": torque,
        "travel": covered.travel + way,
        "reversal_travel": way - way[start],
        "reversal_time": time - time[start],
        "reversed_before": (np.cumsum(turned) > 0).astype(np.float64),
        "steady": steady,
        "step": np.where(np.arange(n) > 0, STEP_S, 0.0),
    }
    arrays: dict[str, Any] = {}
    for name in (f.name for f in fields(Frame) if f.name != "ratio"):
        kind = np.int64 if name == "recording" else np.float64
        arrays[name] = np.ascontiguousarray(np.broadcast_to(np.asarray(values.get(name, 0), dtype=kind), (n,)))
    return Frame(ratio=ratio, **arrays)


def _course(candidate: Candidate) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Velocity, torque and whether the motion is steady, a row each ``STEP_S``."""
    v, torque = candidate.velocity, candidate.torque
    if candidate.sequence == "reversal":
        amplitude = np.radians(float(dict(candidate.options)["amplitude"].strip('"').split()[0]))
        plateau = max(4, round(amplitude / abs(v) / STEP_S))
        turn = max(2, round(_CORNER_S / STEP_S))
        parts = []
        for half in range(2 * CYCLES):
            side = 1.0 if half % 2 == 0 else -1.0
            parts += [np.full(plateau, side * v), np.linspace(side * v, -side * v, turn)]
        velocity = np.concatenate(parts)
        return velocity, np.full(velocity.size, torque), (np.abs(velocity) == abs(v)).astype(np.float64)
    if candidate.sequence == "torque_ramp":
        levels = np.linspace(0.0, torque, STEPS + 1)
        stairs = np.concatenate([levels, levels[-2::-1], -levels[1:], -levels[-2::-1]])
        hold = max(2, round(HOLD_S / STEP_S))
        load = np.repeat(stairs, hold)
        return np.full(load.size, v), load, np.ones(load.size)
    if candidate.sequence == "velocity_ramp":
        velocity = np.concatenate([np.linspace(0.02, 1.0, 100), np.linspace(1.0, 0.02, 100)]) * v
        return velocity, np.full(velocity.size, torque), np.zeros(velocity.size)
    n = int(np.clip(2.0 * np.pi / abs(v) / STEP_S, 40, 240))
    return np.full(n, v), np.full(n, torque), np.ones(n)
