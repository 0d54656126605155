"""A sink beside the recorder that looks at the true shafts of an emulated bench, whatever its sensors say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.cycle.sink import Sink
from bench.protocols import Segment


@dataclass(frozen=True, slots=True)
class Look:
    """The truth at a bus cycle: speeds in rad/s, torque at the sensor in N·m, whether a drive has torque."""

    cycle: int
    motor_speed: float
    load_speed: float
    torque: float
    powered: bool


class Truth:
    """An emulated plant whose true state is kept after every cycle; cycles that are taken back are forgotten.

    Stands in for the plant (``step``, ``snapshot``, ``restore``; anything else is the plant's own).
    """

    def __init__(self, bench: Any) -> None:
        self._plant, self._drives, self._cycle = bench.plant, bench.drives, int(bench.cycle)
        self.looks: list[Look] = []

    @staticmethod
    def of(master: Any) -> Truth:
        """Return the truth of an emulated master's bench; put there if it is the first time."""
        bench = master.bench
        if not isinstance(bench.plant, Truth):
            bench.plant = Truth(bench)
        truth: Truth = bench.plant
        return truth

    def __getattr__(self, name: str) -> Any:
        return getattr(self._plant, name)

    def step(self, commands: NDArray[Any]) -> NDArray[Any]:
        """Run and look at every cycle of ``commands``; whether a drive has torque is that of the block's begin."""
        measured, trace = self._plant.step_traced(commands)
        powered = self._powered()
        seen = (np.abs(trace[name]).tolist() for name in ("motor_velocity", "load_velocity", "torque"))
        for cycle, (motor, load, torque) in enumerate(zip(*seen, strict=True), self._cycle + 1):
            self.looks.append(Look(cycle, motor, load, torque, powered))
        self._cycle += len(trace)
        return np.asarray(measured)

    def look(self) -> None:
        """Look now."""
        state = self._plant.state
        speeds = abs(state["motor_velocity"]), abs(state["load_velocity"])
        self.looks.append(Look(self._cycle, *speeds, abs(state["torque"]), self._powered()))

    def _powered(self) -> bool:
        return any(drive.power.powered for drive in self._drives)

    def snapshot(self) -> tuple[Any, int]:
        """Return a token of plant and cycle."""
        return self._plant.snapshot(), self._cycle

    def restore(self, token: tuple[Any, int]) -> None:
        """Go back, and forget what was seen since."""
        plant, self._cycle = token
        self._plant.restore(plant)
        while self.looks and self.looks[-1].cycle > self._cycle:
            self.looks.pop()


class Shafts:
    """Passes rows on and keeps what the shafts do, cycle by cycle; ``master`` is the emulated one."""

    def __init__(self, sink: Sink | None, master: Any) -> None:
        self._sink, self._master = sink, master
        self.looks: list[Look] = []
        if master is not None:
            Truth.of(master).looks = self.looks
            self.look()
        self.kept: list[NDArray[np.int64]] = []
        """Cycle and motor encoder counts of every row handed on, (n, 2)."""
        self.events: list[str] = []

    def segment(self, segment: Segment | None) -> None:
        """Pass on."""
        if self._sink is not None:
            self._sink.segment(segment)

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        """Keep and pass on."""
        if self._sink is not None:
            self._sink.rows(raw)
        self.kept.append(np.column_stack((raw["cycle"], raw["motor_angle"])).astype(np.int64))

    def event(self, level: str, text: str) -> None:
        """Keep and pass on."""
        self.events.append(text)
        if self._sink is not None:
            self._sink.event(level, text)

    def look(self) -> None:
        """Look at the shafts now."""
        Truth.of(self._master).look()

    def at(self, cycle: int) -> tuple[float, float] | None:
        """Return load-side speed in rad/s and torque in N·m at the begin of a cycle; None if nobody looked by then."""
        look = next((look for look in reversed(self.looks) if look.cycle <= cycle), None)
        return None if look is None else (look.load_speed, look.torque)

    def silence(self, duration_s: float) -> None:
        """Let emulated time pass without a frame, as after the last one: the drives' watchdogs act."""
        master, n = self._master, 40
        outputs = np.zeros((n, sum(len(slave.output_bytes) for slave in master.slaves)), np.uint8)
        inputs = np.zeros((n, sum(len(slave.input_bytes) for slave in master.slaves)), np.uint8)
        for _ in range(round(duration_s / master.bench.cycle_time_s / n)):
            master.faults.apply("frame_lost", value=n)
            master.exchange_block(outputs, inputs, np.zeros(n, np.int32))
            self.look()
        master.faults.clear("frame_lost")

    def peaks(self) -> tuple[float, float, float]:
        """Largest motor speed, load speed and torque so far."""
        looks = self.looks
        return max(x.motor_speed for x in looks), max(x.load_speed for x in looks), max(x.torque for x in looks)

    def settled(self, cycle: int, motor_standstill: float, load_standstill: float) -> tuple[int | None, int | None]:
        """Return the cycles from which on, after ``cycle``, both shafts rest and no drive has torque; None if never."""

        def last(moving: list[bool]) -> int | None:
            late = [look for look in self.looks if look.cycle >= cycle]
            bad = [i for i, still in enumerate(moving) if still]
            if not bad:
                return late[0].cycle if late else None
            return late[bad[-1] + 1].cycle if bad[-1] + 1 < len(late) else None

        late = [look for look in self.looks if look.cycle >= cycle]
        resting = last([x.motor_speed >= motor_standstill or x.load_speed >= load_standstill for x in late])
        return resting, last([x.powered for x in late])
