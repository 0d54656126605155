"""Points that a bench could run next, as rows of ideal motion: what each explanation would predict there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.recordings.dataset import Dataset
from bench.simulation.frame import ARRAYS, FloatArray, Frame

STEP_S = 0.25
REVERSALS_RAD = (np.radians(2.0), np.radians(10.0), np.radians(40.0))
CYCLES, STEPS, HOLD_S = 3, 5, 2.0
CORNER_S = 0.5
"""how long a reversal takes"""
LATER_S = 1800.0
"""when a campaign made of the proposal begins, after the last recording"""
WARMER = 6.0
"""K by which the warmest recordings are above the coldest where heating is worth its while"""
THERMAL = ("heating", "cooling", "dwell")
"""kinds of recordings that are no operating points"""


@dataclass(frozen=True, slots=True)
class Range:
    """What the recordings have covered: torque up to ``torque`` N·m, output speeds rad/s, temperatures °C, and the end
    of the campaign (s) and its travel (rad).

    ``heats``: the temperature is set (by warming up or by setpoints), it does not only happen; ``sides``: signs of the
    speeds and of the torques that were driven.
    """

    torque: float
    slowest: float
    fastest: float
    coldest: float
    warmest: float
    end: float
    travel: float
    heats: bool = True
    sides: tuple[float, ...] = (1.0, -1.0)
    torque_sides: tuple[float, ...] = (1.0, -1.0)

    @classmethod
    def of(cls, data: Dataset) -> Range:
        """Read the range from the setpoints and the recordings themselves; heating speeds are no operating points."""
        setpoints = [(m.recording.kind, m.recording.setpoint) for m in data.members]
        torque = [s.load_torque for _, s in setpoints if np.isfinite(s.load_torque)]
        speed = [
            s.velocity for kind, s in setpoints if np.isfinite(s.velocity) and s.velocity != 0.0 and kind not in THERMAL
        ]
        setpoint_temperatures = [s.temperature for _, s in setpoints if np.isfinite(s.temperature)]
        frames = [rows.frame for rows in data.rows.values()]
        known = [f.temperature for f in frames if np.ptp(f.temperature) > 0.0]
        temperature = (
            np.concatenate(known) if known else np.array(setpoint_temperatures or [criteria.REFERENCE_CELSIUS])
        )
        both = any(kind == "reversal" for kind, _ in setpoints)
        return cls(
            float(np.floor(max(map(abs, torque), default=0.0))),
            min(map(abs, speed), default=0.0),
            max(map(abs, speed), default=0.0),
            float(np.percentile(temperature, 2)),
            float(np.percentile(temperature, 98)),
            max((float(f.time.max()) for f in frames), default=0.0),
            max((float(f.travel.max()) for f in frames), default=0.0),
            any(kind in ("heating", "cooling") for kind, _ in setpoints)
            or len(set(np.round(setpoint_temperatures, 1))) > 1,
            tuple(s for s in (1.0, -1.0) if both or any(s * v > 0 for v in speed)),
            tuple(s for s in (1.0, -1.0) if any(s * t > 0 for t in torque)),
        )

    @property
    def warm(self) -> float | None:
        """Temperature to warm up to, °C; None where this bench does not warm up, or hardly."""
        if not self.heats or not self.warmest - self.coldest > WARMER:
            return None
        return float(round(self.warmest))

    def loads(self, shares: tuple[float, ...]) -> tuple[float, ...]:
        """Load torques that are ``shares`` of the largest, of the signs that were driven."""
        kept = [s for s in shares if s == 0.0 or float(np.sign(s)) in self.torque_sides]
        return tuple(dict.fromkeys(float(round(s * self.torque)) for s in kept))


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


def stairs(covered: Range, temperature: float | None = None) -> Iterator[Candidate]:
    """A staircase of torque through both signs up to the largest; none where torques of one sign were driven only."""
    if covered.torque > 0.0 and len(covered.torque_sides) == 2:
        options = (("steps", f"{STEPS}"), ("hold", f'"{HOLD_S:g} s"'))
        yield Candidate("torque_ramp", covered.torque, 0.5 * covered.fastest * covered.sides[0], temperature, options)


def reversals(
    covered: Range, amplitude: float, torques: tuple[float, ...], temperature: float | None = None
) -> Iterator[Candidate]:
    """Reversals by an ``amplitude`` (rad) under preloads; none where only one direction was driven."""
    if len(covered.sides) == 2:
        options = (("amplitude", f'"{np.degrees(amplitude):g} deg"'), ("cycles", f"{CYCLES}"))
        for torque in torques:
            yield Candidate("reversal", torque, 0.3 * covered.fastest, temperature, options)


def candidates(covered: Range) -> Iterator[Candidate]:
    """Admissible points: within the torques, speeds and temperatures that the bench has run, and slower."""
    temperatures = (None,) if covered.warm is None else (None, covered.warm)
    speeds = tuple(covered.fastest * share for share in (0.05, 0.15, 0.4, 1.0))
    for temperature in temperatures:
        for torque in covered.loads((0.0, 0.1, 0.3, -0.3, 1.0, -1.0)):
            for speed in speeds:
                for side in covered.sides:
                    yield Candidate("constant_velocity", torque, side * speed, temperature)
        for amplitude in REVERSALS_RAD:
            yield from reversals(covered, float(amplitude), covered.loads((0.0, 0.3)), temperature)
        yield from stairs(covered, temperature)
        ramp = covered.fastest * covered.sides[0]
        yield Candidate("velocity_ramp", 0.0, ramp, temperature, (("duration", '"30 s"'),))


def frame_of(candidate: Candidate, covered: Range, ratio: float) -> Frame:
    """Rows of the candidate's ideal motion, a quarter of a second each; steady but for its changes."""
    velocity, torque, steady = _course(candidate)
    n = velocity.size
    time = STEP_S * np.arange(n)
    theta = np.cumsum(velocity) * STEP_S
    temperature = covered.coldest if candidate.temperature is None else candidate.temperature
    direction = np.sign(velocity)
    reversals = np.concatenate(([False], direction[1:] * direction[:-1] < 0))
    start = np.maximum.accumulate(np.where(reversals, np.arange(n), 0))
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
        "torque_level": torque,
        "torque_rate": np.gradient(torque, STEP_S) if n > 1 else 0.0,
        "temperature": temperature,
        "load_motor_torque": torque,
        "load_motor_level": torque,
        "travel": covered.travel + way,
        "reversal_travel": way - way[start],
        "reversal_time": time - time[start],
        "reversed_before": (np.cumsum(reversals) > 0).astype(np.float64),
        "steady": steady,
        "step": np.where(np.arange(n) > 0, STEP_S, 0.0),
    }
    arrays: dict[str, Any] = {}
    for name in ARRAYS:
        kind = np.int64 if name == "recording" else np.float64
        arrays[name] = np.ascontiguousarray(np.broadcast_to(np.asarray(values.get(name, 0), dtype=kind), (n,)))
    return Frame(ratio=ratio, **arrays)


def _course(candidate: Candidate) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Velocity, torque and whether the motion is steady, a row each ``STEP_S``."""
    v, torque = candidate.velocity, candidate.torque
    if candidate.sequence == "reversal":
        amplitude = np.radians(float(dict(candidate.options)["amplitude"].strip('"').split()[0]))
        plateau = max(4, round(amplitude / abs(v) / STEP_S))
        corner = max(2, round(CORNER_S / STEP_S))
        parts = []
        for half in range(2 * CYCLES):
            side = 1.0 if half % 2 == 0 else -1.0
            parts += [np.full(plateau, side * v), np.linspace(side * v, -side * v, corner)]
        velocity = np.concatenate(parts)
        return velocity, np.full(velocity.size, torque), (np.abs(velocity) == abs(v)).astype(np.float64)
    if candidate.sequence == "torque_ramp":
        levels = np.linspace(0.0, torque, STEPS + 1)
        staircase = np.concatenate([levels, levels[-2::-1], -levels[1:], -levels[-2::-1]])
        hold = max(2, round(HOLD_S / STEP_S))
        load = np.repeat(staircase, hold)
        return np.full(load.size, v), load, np.ones(load.size)
    if candidate.sequence == "velocity_ramp":
        velocity = np.concatenate([np.linspace(0.02, 1.0, 100), np.linspace(1.0, 0.02, 100)]) * v
        return velocity, np.full(velocity.size, torque), np.zeros(velocity.size)
    n = int(np.clip(2.0 * np.pi / abs(v) / STEP_S, 40, 240))
    return np.full(n, v), np.full(n, torque), np.ones(n)
