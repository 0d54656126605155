"""Distributed clocks: the propagation delays are measured once, then SYNC0 starts in the slaves that run on it.

The master's cycle is not steered by the slaves' reference clock: it keeps deadlines of the computer's monotonic clock
(:mod:`drivers.ethercat.pacing`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from drivers.ethercat.protocols import Master, Slave
from drivers.ethercat.slave import SlaveSpec


def set_up_clocks(master: Master, specs: Sequence[SlaveSpec]) -> None:
    """Measure the delays between the slaves and set their clocks; nothing where no slave runs on SYNC0."""
    if any(spec.sync0_shift_ns is not None for spec in specs):
        master.config_dc()


def start_sync0(
    specs: Sequence[SlaveSpec], slaves: Sequence[Slave], cycle_time_s: float, send: Callable[[], object]
) -> None:
    """Start SYNC0 at the bus cycle, with each slave's shift, where one is configured; ``send`` exchanges one cycle."""
    for spec, slave in zip(specs, slaves, strict=True):
        if spec.sync0_shift_ns is not None:
            send()  # cycle data before SYNC0, or the slave's clock control sees a jump
            slave.dc_sync(True, round(cycle_time_s * 1e9), spec.sync0_shift_ns)
