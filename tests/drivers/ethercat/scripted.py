"""A master with pysoem's API and no memory of its own: tests script what it answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pysoem

from drivers.entries import TYPES, entries_dtype
from drivers.errors import DriverError
from drivers.ethercat import SlaveSpec

INIT, PREOP, SAFEOP, OP = 1, 2, 4, 8


@dataclass
class ScriptedSlave:
    """A slave whose object dictionary is a plain mapping of bytes."""

    man: int
    id: int
    rev: int
    name: str
    objects: dict[tuple[int, int], bytes] = field(default_factory=dict)
    output_size: int = 0
    input_size: int = 0
    state: int = PREOP
    al_status: int = 0
    is_lost: bool = False
    config_func: Callable[[int], None] | None = None
    watchdog_ms: float = 100.0
    writes: list[tuple[int, int, bytes]] = field(default_factory=list)
    requested: list[int] = field(default_factory=list)
    sdo_script: list[Exception | None] = field(default_factory=list)
    recovers: int = 1
    reconfigures_to: int = SAFEOP
    keeps: dict[tuple[int, int], bytes] = field(default_factory=dict)
    callbacks: list[Callable[[Any], None]] = field(default_factory=list)
    mailbox: list[Any] = field(default_factory=list)
    sync0: tuple[bool, int, int] | None = None

    def __post_init__(self) -> None:
        self.output = bytes(self.output_size)
        self.input = bytes(self.input_size)

    def _next(self) -> None:
        if self.sdo_script and (error := self.sdo_script.pop(0)) is not None:
            raise error

    def sdo_read(self, index: int, subindex: int, size: int = 0, ca: bool = False) -> bytes:
        self._next()
        if (index, subindex) not in self.objects:
            raise pysoem.SdoError(1, index, subindex, 0x06020000, "no object")
        return self.objects[index, subindex]

    def sdo_write(self, index: int, subindex: int, data: bytes, ca: bool = False) -> None:
        self._next()
        self.writes.append((index, subindex, data))
        self.objects[index, subindex] = self.keeps.get((index, subindex), data)

    def write_state(self) -> int:
        self.requested.append(self.state)
        self.state &= 0x0F
        return 1

    def state_check(self, expected_state: int, timeout: int = 2000) -> int:
        return self.state

    def reconfig(self, timeout: int = 500) -> int:
        if self.config_func is not None:
            try:
                self.config_func(0)
            except DriverError:  # pysoem swallows it here as well
                self.state = PREOP | 0x10
                return INIT
        self.state = self.reconfigures_to
        return self.state

    def recover(self, timeout: int = 500) -> int:
        if self.recovers > 0:
            self.state = INIT
        return self.recovers

    def set_watchdog(self, wd_type: str, wd_time_ms: float) -> None:
        if wd_time_ms > 6553.5:
            raise AttributeError("wd_time_ms is limited to 6553.5 ms")
        self.watchdog_ms = int(wd_time_ms * 10) / 10

    def get_watchdog(self, wd_type: str) -> float:
        return self.watchdog_ms

    def dc_sync(self, act: bool, sync0_cycle_time: int, sync0_shift_time: int = 0) -> None:
        self.sync0 = (act, sync0_cycle_time, sync0_shift_time)

    def add_emergency_callback(self, callback: Callable[[Any], None]) -> None:
        self.callbacks.append(callback)

    def mbx_receive(self) -> int:
        if self.mailbox:
            message = self.mailbox.pop(0)
            if isinstance(message, pysoem.Emergency):
                for callback in self.callbacks:
                    callback(message)
            else:
                raise message
        return 1

    def put(self, index: int, subindex: int, type_: str, value: int) -> None:
        self.objects[index, subindex] = np.array(value, TYPES[type_]).tobytes()

    def get(self, index: int, subindex: int, type_: str) -> int:
        return int(np.frombuffer(self.objects[index, subindex], TYPES[type_])[0])


@dataclass
class ScriptedMaster:
    """Slaves in a list; ``answer`` makes the inputs and the working counter of a cycle."""

    slaves: list[ScriptedSlave] = field(default_factory=list)
    answer: Callable[[ScriptedMaster], int] | None = None
    state: int = 0
    expected_wkc: int = 3
    opened: str | None = None
    log: list[str] = field(default_factory=list)
    map_error: Exception | None = None
    unmapped: int = 0
    """times that the first slave does not say its PDOs"""
    refuses: dict[int, tuple[int, int]] = field(default_factory=dict)
    cycles: int = 0
    timeouts: list[int] = field(default_factory=list)

    def open(self, ifname: str) -> None:
        if ifname == "missing":
            raise ConnectionError("could not open interface missing")
        self.opened = ifname

    def close(self) -> None:
        self.log.append("close")
        self.opened = None

    def config_init(self) -> int:
        return len(self.slaves) or -1

    def config_map(self) -> int:
        for place, slave in enumerate(self.slaves):
            if slave.config_func is not None:
                slave.config_func(place)
            slave.state = SAFEOP
            silent = place == 0 and self.unmapped > 0
            slave.output = b"" if silent else slave.output or bytes(slave.output_size)
        self.unmapped -= 1
        if self.map_error is not None:
            raise self.map_error
        return sum(slave.output_size + slave.input_size for slave in self.slaves)

    def config_dc(self) -> bool:
        self.log.append("dc")
        return True

    def read_state(self) -> int:
        return min((slave.state for slave in self.slaves), default=0)

    def write_state(self) -> int:
        self.log.append(f"state {self.state}")
        for slave in self.slaves:
            if self.state in self.refuses:
                slave.state, slave.al_status = self.refuses[self.state]
            else:
                slave.state = self.state
        return 1

    def state_check(self, expected_state: int, timeout: int = 50000) -> int:
        found = 0
        for slave in self.slaves:
            found |= slave.state
        return found

    def send_processdata(self) -> int:
        return 1

    def receive_processdata(self, timeout: int = 2000) -> int:
        self.cycles += 1
        self.timeouts.append(timeout)
        return self.expected_wkc if self.answer is None else self.answer(self)


def slave_for(spec: SlaveSpec) -> ScriptedSlave:
    """Return a scripted slave that is what a specification asks for."""
    out, in_ = entries_dtype(spec.outputs).itemsize, entries_dtype(spec.inputs).itemsize
    return ScriptedSlave(spec.vendor, spec.product, spec.revision or 1, spec.name, output_size=out, input_size=in_)
