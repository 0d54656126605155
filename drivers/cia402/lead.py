"""Lead drives to a goal over a bus, in blocks of one cycle: the one loop every caller would write."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from drivers.cia402.sequence import Goal, Outcome
from drivers.cia402.servo_drive import ServoDrive


class Cyclic(Protocol):
    """A bus as far as it is needed here."""

    def exchange(self, n: int = 1) -> Any:
        """Run n cycles."""
        ...


def lead(
    bus: Cyclic,
    drives: Sequence[ServoDrive],
    goal: Goal,
    timeout_s: float = 2.0,
    on_cycle: Callable[[Any], None] | None = None,
) -> int:
    """Lead all drives to one goal; returns the cycles it took.

    Set values are sent as they stand in the outputs once a drive is enabled: put them to zero, or to the present
    velocity, first.

    Parameters
    ----------
    bus : bus the drives are attached to.
    drives : drives to lead; the others of the bus keep the outputs they have.
    goal : what to lead them to.
    timeout_s : after which a drive that is not there has failed, s.
    on_cycle : called with every exchange, for a safety step that must see each cycle.

    Raises
    ------
    DriveFaultError
        With the fault of the first drive that failed, or the state it stayed in.
    """
    for drive in drives:
        drive.request(goal, timeout_s)
    cycles = 0
    while any(drive.sequence.outcome is not Outcome.REACHED for drive in drives):
        for drive in drives:
            drive.prepare(1)
        exchange = bus.exchange(1)
        cycles += 1
        if on_cycle is not None:
            on_cycle(exchange)
        for drive in drives:
            drive.digest(1)
            drive.check(1)
    return cycles
