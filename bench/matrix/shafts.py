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


class Shafts:
    """Passes rows on and keeps what the shafts do; ``master`` is the emulated one."""

    def __init__(self, sink: Sink | None, master: Any) -> None:
        self._sink, self._master = sink, master
        self.looks: list[Look] = []
        self.kept: list[NDArray[np.int64]] = []
        """Cycle and motor encoder counts of every row handed on, (n, 2)."""
        self.events: list[str] = []

    def segment(self, segment: Segment | None) -> None:
        """Pass on."""
        if self._sink is not None:
            self._sink.segment(segment)

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        """Look, then pass on."""
        self.look()
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
        bench = self._master.bench
        state = bench.plant.state
        powered = any(drive.power.powered for drive in bench.drives)
        self.looks.append(
            Look(bench.cycle, abs(state["motor_velocity"]), abs(state["load_velocity"]), abs(state["torque"]), powered)
        )

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
