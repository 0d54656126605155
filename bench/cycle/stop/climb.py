"""Climb the stop ladder on a rig: what each rung sends, until the bench is at rest without voltage.

Deadlines are those of the rig's clock, whatever the number of cycles that came meanwhile.
"""

from __future__ import annotations

import time
from datetime import datetime
from typing import Protocol

from bench.configuration import BenchConfiguration
from bench.cycle.decode import Decoded
from bench.cycle.sink import Sink
from bench.cycle.stop.coast_down import CoastDown
from bench.protocols import Segment
from bench.safety import Cause, Deadlines, LadderState, Observation, Rung, StopRecord, climb, first_rung
from bench.safety.stop_record import RungRecord, rung_name

_STEP_S = 0.02
_DEAD_S = 0.05
"""A bus that is silent for so long is dead: half of what the drives' watchdogs allow."""
_TEXT: dict[Rung, str] = {
    Rung.CONTROLLED_RAMP: "controlled ramp: load off, then the input to rest",
    Rung.QUICK_STOP: "quick stop of the drives",
    Rung.DISABLE_VOLTAGE: "voltage off",
    Rung.STOP_SENDING: "process data stopped: the drives' watchdogs have to act, which nobody sees from here",
}
_GOALS: dict[Rung, str] = {Rung.QUICK_STOP: "QUICK_STOP", Rung.DISABLE_VOLTAGE: "DISABLED"}


class StoppableRig(Protocol):
    """What the ladder needs of a rig."""

    @property
    def set_values(self) -> tuple[float, float]:
        """Set velocity and torque handed over last, load side."""
        ...

    @property
    def sent_values(self) -> tuple[float, float]:
        """Set velocity and torque sent last, load side."""
        ...

    def clock(self) -> float:
        """Time by which deadlines are kept, s."""
        ...

    def missing_ahead(self, n: int) -> int:
        """Return how many cycles are to be handed over so that a rig that is late delays no ramp."""
        ...

    def drop_ahead(self) -> None:
        """Take back what was handed over and not sent."""
        ...

    def stop_cycles(self, n: int, least: int, velocity: float, torque: float, goal: str | None, sink: Sink) -> Decoded:
        """Hand over ``n`` cycles towards set values, return ``least`` cycles or more that came."""
        ...

    def go_silent(self) -> None:
        """Send no process data from now on."""
        ...

    def drives_off(self) -> bool:
        """Whether no drive has voltage."""
        ...

    @property
    def is_real_time(self) -> bool:
        """Whether bench time is the clock's."""
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
        self._deadlines = Deadlines(stopping.controlled_ramp, stopping.quick_stop, stopping.disable_voltage)
        self._coast = CoastDown(bench.motion.standstill, bench.gearbox.ratio, cycle_time_s)
        self._begun: list[tuple[Rung, float, int | None]] = []
        self._rest_seen_at_ns: int | None = None

    def run(self, cause: Cause, sink: Sink, text: str = "") -> StopRecord:
        """Bring the bench to rest; every rung and its time stand in the recording's events.

        Returns the record of the stop; ``text`` is the sentence that says why.
        """
        sink.segment(Segment.RAMP_DOWN)
        rig, state, began = self._rig, LadderState(first_rung(cause)), self._rig.now
        start = now = rig.clock()
        announced = Rung.NONE
        while True:
            goal = None
            if state.rung is not announced:
                announced = state.rung
                goal = _GOALS.get(announced)
                self._begun.append((announced, now - start, self._unix_ns()))
                if announced is Rung.STOP_SENDING:
                    rig.go_silent()
                if announced in (Rung.FINISHED, Rung.STOP_SENDING):
                    return self._end(announced, self._record(cause, text, began, now - start), sink)
                rig.drop_ahead()
                sink.event("info", _TEXT[announced])
            n, velocity, torque = self._targets(state.rung)
            seen = rig.stop_cycles(n, self._n, velocity, torque, goal, sink)
            self._coast.keep(seen)
            self._look_for_rest()
            before, now = now, rig.clock()
            state = climb(state, self._observe(), now - before, self._deadlines)

    def _end(self, rung: Rung, record: StopRecord, sink: Sink) -> StopRecord:
        sink.event("info", record.summary)
        sink.event("info", _TEXT.get(rung) or record.rest_text)
        return record

    def _record(self, cause: Cause, text: str, began: datetime, lasted_s: float) -> StopRecord:
        ends = [start for _, start, _ in self._begun[1:]] + [lasted_s]
        to_rest_s = self._coast.to_rest_s(self._alive)
        alive = self._alive
        return StopRecord(
            cause=cause,
            text=text,
            at=began,
            cycle=self._coast.first_cycle,
            rungs=tuple(
                RungRecord(rung_name(rung), start, end - start, at_ns)
                for (rung, start, at_ns), end in zip(self._begun, ends, strict=True)
                if rung is not Rung.FINISHED
            ),
            to_rest_s=to_rest_s,
            rest_seen_at_ns=None if to_rest_s is None else self._rest_seen_at_ns,
            shafts_at_rest=self._coast.at_rest(alive),
            lasted_s=lasted_s,
            motor_travel_rad=self._coast.travel_rad,
            coast_down=self._coast.samples,
            drives=self._rig.drive_states
            if alive and self._coast.first_cycle is not None
            else dict.fromkeys(self._rig.drive_states, "not seen"),
        )

    def _unix_ns(self) -> int | None:
        """Now by the clock, Unix time in ns; None where the bench's time is not the clock's."""
        return time.time_ns() if self._rig.is_real_time else None

    def _look_for_rest(self) -> None:
        """Stamp the moment from which on both shafts are seen at rest."""
        if not all(self._coast.at_rest(self._alive).values()):
            self._rest_seen_at_ns = None
        elif self._rest_seen_at_ns is None:
            self._rest_seen_at_ns = self._unix_ns()

    def _targets(self, rung: Rung) -> tuple[int, float, float]:
        """Return how many cycles to hand over, and the set values at their end."""
        if rung is not Rung.CONTROLLED_RAMP:
            return self._n, 0.0, 0.0
        velocity, torque = self._rig.set_values
        n, motion = self._rig.missing_ahead(self._n), self._bench.motion
        step = n * self._cycle_time
        if torque != 0.0:
            return n, velocity, _towards_zero(torque, motion.torque_rate * step)
        return n, _towards_zero(velocity, motion.motor_acceleration / self._bench.gearbox.ratio * step), 0.0

    @property
    def _alive(self) -> bool:
        return self._coast.silent_s < _DEAD_S

    def _observe(self) -> Observation:
        alive, rest = self._alive, self._coast.at_rest()
        velocity, torque = self._rig.sent_values
        return Observation(
            at_rest=alive and velocity == 0.0 and self._coast.input_is_slow,
            load_off=torque == 0.0,
            drives_off=self._rig.drives_off(),
            bus_alive=alive,
            seen_at_rest=alive and rest["input"] is True and rest["load"] is True,
        )


def _towards_zero(value: float, step: float) -> float:
    return max(0.0, value - step) if value > 0.0 else min(0.0, value + step)
