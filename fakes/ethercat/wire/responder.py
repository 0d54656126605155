"""The emulated bench on a network interface: frames in, frames out, the plant in real time.

A frame is answered first, with the inputs of the cycle before, as slaves do that copy their inputs when the frame
arrives; then the plant goes on by one cycle. The plant keeps to the wall clock: it follows the master's cycle as long
as that is the bus cycle, and runs on by itself where no frame comes. It may be set to wait a while before it does: a
computer that stalls both master and emulator then costs no cycle, where the master makes up for those it is late with.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fakes.ethercat.bench import EmulatedBench
from fakes.ethercat.faults import FaultSwitch
from fakes.ethercat.slaves.slave import Image
from fakes.ethercat.wire.esc import SlaveController
from fakes.ethercat.wire.port import Port
from fakes.ethercat.wire.registers import WATCHDOG_STATUS
from fakes.ethercat.wire.segment import ETHERNET, LRD, LRW, Segment

_COMMAND = ETHERNET + 2
"""Place of the first datagram's command in a frame."""

SLACK_CYCLES = 1.5
"""How far the plant may be from the wall clock before a cycle is added or left out."""

ALONE_CYCLES = 3.0
"""How far the plant stays behind the wall clock while no frame comes, so that one that comes finds its cycle."""

TRACKING, LOCKED_CYCLES = 0.01, 0.5
"""Part of the phase error by which the clock follows the master at each frame, as long as the error is below this."""


READING_CYCLES = 100
"""Cycles between updates of the PT100 readings."""


class Readings(Protocol):
    """Numbers that can be set by index, shared with another process perhaps."""

    def __setitem__(self, index: int, value: float, /) -> None:
        """Set a number."""
        ...


@dataclass(slots=True)
class Counters:
    """What the responder has done."""

    frames: int = 0
    process_frames: int = 0
    malformed: int = 0
    dropped: int = 0
    cycles: int = 0
    added_cycles: int = 0
    left_out_cycles: int = 0
    longest_answer_us: float = 0.0


class Responder:
    """Answers frames for the slaves of a bench.

    Parameters
    ----------
    bench : slaves and plant.
    port : where frames come from.
    readings : two numbers that are kept at the PT100 readings in °C, for transmitters elsewhere.
    make_up_s : how long the plant waits behind the wall clock for a master that makes up for cycles it is late with.
    """

    def __init__(
        self, bench: EmulatedBench, port: Port, readings: Readings | None = None, make_up_s: float = 0.0
    ) -> None:
        self._readings = readings
        self.bench = bench
        self.faults = FaultSwitch(bench)
        self.counters = Counters()
        self.commands: deque[Callable[[], None]] = deque()
        """What other threads want done between two frames."""
        self.segment = Segment([SlaveController(slave) for slave in bench.slaves])
        self.segment.on_change = self._forget
        self._port = port
        self._frame = bytearray(2048)
        self._view = memoryview(self._frame)
        self._cycle_ns = bench.cycle_time_s * 1e9
        waits = make_up_s / bench.cycle_time_s
        self._slack, self._alone = max(SLACK_CYCLES, waits), max(ALONE_CYCLES, waits)
        self._make_up_ns, self._behind_since = make_up_s * 1e9, 0
        self._start_ns = float(time.monotonic_ns())
        self._done = 0
        self._following = False
        self._heard_ns = [time.monotonic_ns()] * len(bench.slaves)
        self._lost: frozenset[str] = frozenset()
        self._images: tuple[list[Image | None], list[Image | None]] = ([], [])
        self._stop = False

    def stop(self) -> None:
        """Make :meth:`run` return."""
        self._stop = True

    def warm_up(self) -> None:
        """Run a few cycles, so that what is compiled on first use is compiled before the first frame."""
        nothing: list[Image | None] = [None] * len(self.bench.slaves)
        for cycles in (1, 8):
            self.bench.run(nothing, nothing, cycles)
        self._show_readings()
        self._start_ns, self._done = float(time.monotonic_ns()), 0

    def run(self) -> None:
        """Serve until :meth:`stop`."""
        while not self._stop:
            self.serve()

    def serve(self) -> None:
        """Wait for one frame at most and answer it, then bring the plant up to now."""
        length = self._port.receive(self._frame)
        while self.commands:
            self.commands.popleft()()
            self.rearrange()
        now = time.monotonic_ns()
        if not length:
            self._run_alone(now)
            return
        bus = self.faults.bus
        if bus.frames_to_lose and LRD <= self._frame[_COMMAND] <= LRW:
            bus.frames_to_lose -= 1
            self.counters.dropped += 1
            return
        if not self.segment.present:
            self._run_alone(now)
            return
        if not self.segment.serve(self._frame, length):
            self.counters.malformed += 1
            return
        process = self.segment.process_data
        if process and bus.frames_to_delay:
            bus.frames_to_delay -= 1
            time.sleep(bus.late_s)
        self._port.send(self._view[:length])
        counters = self.counters
        counters.frames += 1
        if process:
            counters.process_frames += 1
            counters.longest_answer_us = max(counters.longest_answer_us, (time.monotonic_ns() - now) / 1000.0)
            self.segment.process_data = False
            self._follow(now)
        else:
            self._run_alone(now)

    # -- time ---------------------------------------------------------------------------------------------------

    def _follow(self, now: int) -> None:
        """Run the cycle of a process data frame: one, unless the wall clock has gone elsewhere."""
        for i, (controller, silent) in enumerate(zip(self.segment.present, self.segment.silent, strict=True)):
            if not silent:
                self._heard_ns[self._index(controller, i)] = now
        behind = (now - self._start_ns) / self._cycle_ns - self._done - 0.5
        cycles = 1
        if behind <= SLACK_CYCLES:
            self._behind_since = now
        if not self._following and abs(behind) <= self._alone + SLACK_CYCLES:
            self._start_ns += behind * self._cycle_ns  # a master starts: its phase is the one to keep
        elif behind > self._slack or (behind > SLACK_CYCLES and now - self._behind_since > 2.0 * self._make_up_ns):
            # nobody makes up for them
            cycles += int(behind)
            self.counters.added_cycles += cycles - 1
        elif behind < -SLACK_CYCLES:
            cycles = 0
            self.counters.left_out_cycles += 1
        elif abs(behind) < LOCKED_CYCLES:
            self._start_ns += TRACKING * behind * self._cycle_ns
        self._following = True
        if cycles:
            self._advance(cycles, now)

    def _run_alone(self, now: int) -> None:
        """Run the cycles due by the wall clock that no frame asked for, some behind so that a frame finds its own."""
        due = int((now - self._start_ns) / self._cycle_ns - self._alone) - self._done
        if due > 0:
            self._following = False
            self._advance(due, now)

    def _advance(self, cycles: int, now: int) -> None:
        if self.faults.scheduled:
            self.faults.due(self.bench.cycle)
            self.rearrange()
        outputs, inputs = self._images
        if not outputs:
            outputs, inputs = self._images = self._map()
        if cycles > 1:
            held = [None if rows is None else np.repeat(rows, cycles) for rows in inputs]
            self.bench.idle(cycles, outputs, held)
            for rows, fresh in zip(inputs, held, strict=True):
                if rows is not None and fresh is not None:
                    rows[:] = fresh[-1:]
        else:
            self.bench.run(outputs, inputs, 1)
        self._done += cycles
        self.counters.cycles += cycles
        if self._done // READING_CYCLES != (self._done - cycles) // READING_CYCLES:
            self._show_readings()
        self._look(now)

    def _show_readings(self) -> None:
        if self._readings is not None:
            self._readings[0], self._readings[1] = self.bench.temperatures

    def _look(self, now: int) -> None:
        """Show what the slaves have done by themselves: watchdog, emergencies."""
        for i, controller in enumerate(self.segment.all):
            slave = controller.slave
            status = slave.al.status
            slave.watchdog((now - self._heard_ns[i]) * 1e-9)
            if slave.al.status != status:
                controller.show_watchdog(running=False)
                controller.show_state()
                self._forget()
            elif self._heard_ns[i] == now and not controller.memory[WATCHDOG_STATUS]:
                controller.show_watchdog(running=True)
            if slave.emergencies:
                controller.mailbox.fill()

    # -- arrangement --------------------------------------------------------------------------------------------

    def rearrange(self) -> None:
        """Set which slaves answer, after faults have changed."""
        bus = self.faults.bus
        for controller in self.segment.all:
            if controller.slave.role in self._lost and controller.slave.role not in bus.lost:
                controller.power_on()
        self._lost = frozenset(bus.lost)
        reachable = bus.answering(self.bench)
        present = [c for c, answers in zip(self.segment.all, reachable, strict=True) if answers]
        self.segment.arrange(present, [c.slave.role in bus.short for c in present])
        self._forget()

    def _forget(self) -> None:
        """Map the process images anew before the next cycle."""
        self._images = ([], [])

    def _index(self, controller: SlaveController, guess: int) -> int:
        return guess if self.segment.all[guess] is controller else self.segment.all.index(controller)

    def _map(self) -> tuple[list[Image | None], list[Image | None]]:
        """Return the process images as structured views of the controllers' memory."""
        outputs: list[Image | None] = []
        inputs: list[Image | None] = []
        for controller in self.segment.all:
            slave = controller.slave
            for rows, layout, manager in (
                (outputs, slave.outputs, slave.sync_managers[2]),
                (inputs, slave.inputs, slave.sync_managers[3]),
            ):
                used = slave.exchanging and layout.size > 0
                rows.append(np.ndarray((1,), layout.dtype, controller.memory, manager.start) if used else None)
        return outputs, inputs
