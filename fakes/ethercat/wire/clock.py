"""Distributed-clock registers of one slave controller (ETG.1000.4 §9; ns since 2000-01-01).

All emulated clocks run from the host's monotonic clock, so they never drift; propagation delays are laid out as a line
of slaves would show them, because masters compute delays from the latched receive times.
"""

from __future__ import annotations

import struct
import time

from fakes.ethercat.wire import registers

HOP_NS = 500
"""Time from one slave to the next."""


def local_time_ns() -> int:
    """Return the local clock of every emulated controller."""
    return time.monotonic_ns()


def system_time(memory: bytearray) -> bytes:
    """Return register 0x0910: local clock plus the offset the master wrote."""
    offset = int.from_bytes(memory[registers.DC_OFFSET : registers.DC_OFFSET + 8], "little")
    return ((local_time_ns() + offset) & 0xFFFF_FFFF_FFFF_FFFF).to_bytes(8, "little")


def latch(memory: bytearray, position: int, last: int) -> None:
    """Latch the receive times of a frame that passes a line of slaves (write to 0x0900).

    ``position`` counts from 0, ``last`` is that of the end of the line. The frame passes port 0 on its way out and
    comes back through port 1 after twice the way to the end.
    """
    now = local_time_ns() + position * HOP_NS
    back = now + 2 * (last - position) * HOP_NS
    ports = (now & 0xFFFFFFFF, back & 0xFFFFFFFF if position < last else 0, 0, 0)
    struct.pack_into("<4I", memory, registers.DC_RECEIVE, *ports)
    struct.pack_into("<Q", memory, registers.DC_RECEIVE_UNIT, now)
