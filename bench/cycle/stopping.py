"""Climb the stop ladder on a rig: what each rung sends, until the bench is at rest without voltage."""

from __future__ import annotations

import math
from datetime import datetime
from typing import Protocol

import numpy as np

from bench.configuration import BenchConfiguration
from bench.cycle.decode import Decoded
from bench.cycle.sink import Sink
from bench.protocols import Segment
from bench.safety import Cause, Deadlines, LadderState, Observation, Rung, StopRecord, climb, first_rung
from bench.safety.stop_record import RungRecord, Sample, rung_name

_STEP_S = 0.02
_MOST_SAMPLES = 200
_DEAD_S = 0.05
"""A bus that is silent for so long is dead: half of what the drives' watchdogs allow."""
_TEXT: dict[Rung, str] = {
    Rung.CONTROLLED_RAMP: "controlled ramp: load off, then the input to rest",
    Rung.QUICK_STOP: "quick stop of the drives",
    Rung.DISABLE_VOLTAGE: "voltage off",
    Rung.STOP_SENDING: "process data stopped, the drives' watchdogs act",
    Rung.FINISHED: "bench at rest",
}
_GOALS: dict[Rung, str] = {Rung.QUICK_STOP: "QUICK_STOP", Rung.DISABLE_VOLTAGE: "DISABLED"}


class StoppableRig(Protocol):
    """What the ladder needs of a rig."""

    @property
    def set_values(self) -> tuple[float, float]:
        """Set velocity and torque, load side."""
        ...

    def stop_cycles(self, n: int, velocity: float, torque: float, goal: str | None, sink: Sink) -> Decoded:
        """Run cycles towards set values."""
        ...

    def drives_off(self) -> bool:
        """Whether no drive has voltage."""
        ...

    @property
    def drive_states(self) -> dict[str, str]:
        """State of each drive's state machine, by role."""
        ...

    @property
    def now(self) -> datetime:
        """Time of day on the bench."""
        ...


class Stop:
    """One stop of one rig."""

    def __init__(self, rig: StoppableRig, bench: BenchConfiguration, cycle_time_s: float, block: int) -> None:
        self._rig, self._bench, self._cycle_time = rig, bench, cycle_time_s
        self._n = max(1, min(block, round(_STEP_S / cycle_time_s)))
        stopping = bench.stopping
        self._silent_s = 0.0
        self._deadlines = Deadlines(stopping.controlled_ramp, stopping.quick_stop, stopping.disable_voltage)
        self._elapsed, self._travel = 0.0, 0.0
        self._rest: float | None = None
        self._cycle = -1
        self._begun: list[tuple[Rung, float]] = []
        self._samples: list[Sample] = []

    def run(self, cause: Cause, sink: Sink, text: str = "") -> StopRecord:
        """Bring the bench to rest; every rung and its time stand in the recording's events.

        Returns the record of the stop; ``text`` is the sentence that says why.
        """
        sink.segment(Segment.RAMP_DOWN)
        state, announced, began = LadderState(first_rung(cause)), Rung.NONE, self._rig.now
        step = self._n * self._cycle_time
        while True:
            goal = None
            if state.rung is not announced:
                announced = state.rung
                goal = _GOALS.get(announced)
                self._begun.append((announced, self._elapsed))
                if announced in (Rung.FINISHED, Rung.STOP_SENDING):
                    record = self._record(cause, text, began)
                    sink.event("info", record.summary)
                    sink.event("info", _TEXT[announced])
                    return record
                sink.event("info", _TEXT[announced])
            velocity, torque = self._targets(state.rung, step)
            seen = self._rig.stop_cycles(self._n, velocity, torque, goal, sink)
            self._keep(seen)
            state = climb(state, self._observe(seen), step, self._deadlines)

    def _keep(self, seen: Decoded) -> None:
        """Take a step of the coast-down."""
        inputs, good = seen.inputs, seen.inputs.good
        if self._cycle < 0 and seen.size:
            self._cycle = int(seen.raw["cycle"][0])
        self._elapsed += seen.size * self._cycle_time
        if not good.any():
            return
        speed = float(np.mean(inputs.motor_velocity[good]))
        self._travel += float(np.sum(np.abs(inputs.motor_velocity[good]))) * self._cycle_time
        self._samples.append(
            Sample(
                round(self._elapsed, 6),
                speed,
                float(np.mean(inputs.load_velocity[good])),
                float(np.mean(inputs.load_torque[good])),
            )
        )
        if abs(speed) >= self._bench.motion.standstill:
            self._rest = None
        elif self._rest is None:
            self._rest = self._elapsed

    def _record(self, cause: Cause, text: str, began: datetime) -> StopRecord:
        ends = [start for _, start in self._begun[1:]] + [self._elapsed]
        return StopRecord(
            cause=cause,
            text=text,
            at=began,
            cycle=self._cycle,
            rungs=tuple(
                RungRecord(rung_name(rung), start, end - start)
                for (rung, start), end in zip(self._begun, ends, strict=True)
                if rung is not Rung.FINISHED
            ),
            to_rest_s=self._rest,
            lasted_s=self._elapsed,
            motor_travel_rad=self._travel,
            coast_down=tuple(self._samples[:: max(1, len(self._samples) // _MOST_SAMPLES)]),
            drives=self._rig.drive_states,
        )

    def _targets(self, rung: Rung, step: float) -> tuple[float, float]:
        velocity, torque = self._rig.set_values
        if rung is not Rung.CONTROLLED_RAMP:
            return 0.0, 0.0
        motion = self._bench.motion
        if torque != 0.0:
            return velocity, _towards_zero(torque, motion.torque_rate * step)
        return _towards_zero(velocity, motion.motor_acceleration / self._bench.gearbox.ratio * step), 0.0

    def _observe(self, seen: Decoded) -> Observation:
        good = seen.inputs.good
        self._silent_s = 0.0 if good.any() else self._silent_s + seen.size * self._cycle_time
        alive = self._silent_s < _DEAD_S
        speed = abs(float(np.mean(seen.inputs.motor_velocity[good]))) if good.any() else math.inf
        return Observation(
            at_rest=alive and self._rig.set_values[0] == 0.0 and speed < self._bench.motion.standstill,
            load_off=self._rig.set_values[1] == 0.0,
            drives_off=self._rig.drives_off(),
            bus_alive=alive,
        )


def _towards_zero(value: float, step: float) -> float:
    return max(0.0, value - step) if value > 0.0 else min(0.0, value + step)
