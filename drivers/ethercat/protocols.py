"""The part of pysoem's API the bus relies on, as types: pysoem itself and any stand-in must offer it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

INIT, PREOP, SAFEOP, OP = 0x01, 0x02, 0x04, 0x08
"""AL states (ETG.1000.6, register 0x0130), as in ``pysoem``."""
ERROR, ACK = 0x10, 0x10
"""Error flag of an AL state that was read, acknowledge flag of one that is requested."""


class Slave(Protocol):
    """``pysoem.CdefSlave`` as far as it is used here."""

    name: str
    man: int
    id: int
    rev: int
    state: int
    al_status: int
    is_lost: bool
    config_func: Callable[[int], None] | None
    output: bytes

    @property
    def input(self) -> bytes:
        """Input image of the slave as of the last receive."""
        ...

    def sdo_read(self, index: int, subindex: int, size: int = 0, ca: bool = False) -> bytes:
        """Read an object."""
        ...

    def sdo_write(self, index: int, subindex: int, data: bytes, ca: bool = False) -> None:
        """Write an object."""
        ...

    def write_state(self) -> int:
        """Request the state set in ``state``."""
        ...

    def state_check(self, expected_state: int, timeout: int = 2000) -> int:
        """Wait for a state, timeout in µs."""
        ...

    def reconfig(self, timeout: int = 500) -> int:
        """Bring a slave back to SAFEOP; returns its state."""
        ...

    def recover(self, timeout: int = 500) -> int:
        """Find a slave that was lost; > 0 where it answered."""
        ...

    def set_watchdog(self, wd_type: str, wd_time_ms: float) -> None:
        """Set a watchdog time, ms."""
        ...

    def get_watchdog(self, wd_type: str) -> float:
        """Read a watchdog time, ms."""
        ...

    def dc_sync(self, act: bool, sync0_cycle_time: int, sync0_shift_time: int = 0) -> None:
        """Switch SYNC0, times in ns."""
        ...

    def add_emergency_callback(self, callback: Callable[[Any], None]) -> None:
        """Call back on every CoE emergency message of this slave."""
        ...

    def mbx_receive(self) -> int:
        """Look into the slave's mailbox, where emergency messages wait."""
        ...


class Master(Protocol):
    """``pysoem.Master`` as far as it is used here."""

    state: int

    @property
    def slaves(self) -> Sequence[Slave] | None:
        """Slaves found by :meth:`config_init`, in the order of the bus."""
        ...

    @property
    def expected_wkc(self) -> int:
        """Working counter of an undisturbed cycle."""
        ...

    def open(self, ifname: str) -> None:
        """Open the network interface."""
        ...

    def close(self) -> None:
        """Close the network interface."""
        ...

    def config_init(self) -> int:
        """Find the slaves; their number, or ≤ 0."""
        ...

    def config_map(self) -> int:
        """Configure the slaves and map their process data; SAFEOP is requested."""
        ...

    def config_dc(self) -> bool:
        """Set up distributed clocks."""
        ...

    def read_state(self) -> int:
        """Refresh the state of every slave."""
        ...

    def write_state(self) -> int:
        """Request the state set in ``state`` from all slaves."""
        ...

    def state_check(self, expected_state: int, timeout: int = 50000) -> int:
        """Wait for a state of all slaves, timeout in µs."""
        ...

    def send_processdata(self) -> int:
        """Send the outputs."""
        ...

    def receive_processdata(self, timeout: int = 2000) -> int:
        """Receive the inputs, timeout in µs; the working counter."""
        ...


@runtime_checkable
class BlockMaster(Protocol):
    """A master that can run many cycles in one call."""

    def exchange_block(self, outputs: NDArray[np.uint8], inputs: NDArray[np.uint8], wkc: NDArray[np.int32]) -> int:
        """Run up to n cycles: outputs (n, out_bytes), inputs (n, in_bytes) and wkc (n,) filled; the number done."""
        ...
