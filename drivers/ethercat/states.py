"""Bring the slaves from one AL state to the next, a bounded number of times."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from drivers.errors import BusError
from drivers.ethercat.codes import al_status_text, state_text
from drivers.ethercat.protocols import ACK, ERROR, INIT, OP, SAFEOP, Master, Slave
from drivers.ethercat.slave import SlaveSpec

_STATE_TIMEOUT_US = 50_000
_STEP_TIMEOUT_US = 2_000


def reach_safeop(master: Master, specs: Sequence[SlaveSpec], attempts: int = 100) -> None:
    """Wait until every slave is in SAFEOP (the mapping has requested it), at most ``attempts`` · 50 ms.

    Raises
    ------
    BusError
        With every slave that is not, its state and its AL status in words.
    """
    _request(master, SAFEOP)
    for _ in range(attempts):
        if master.state_check(SAFEOP, _STATE_TIMEOUT_US) == SAFEOP:
            return
        if _acknowledge(master, SAFEOP):
            _request(master, SAFEOP)
    raise BusError(_laggards(master, specs, SAFEOP))


def reach_op(master: Master, specs: Sequence[SlaveSpec], cycle: Callable[[], int], attempts: int) -> None:
    """Bring every slave from SAFEOP to OP while process data runs: a slave enters OP only with valid outputs.

    Parameters
    ----------
    cycle : runs one cycle of process data and returns its working counter.
    attempts : cycles until this is given up. A slave that falls back with an error is acknowledged and asked again.

    Raises
    ------
    BusError
        With every slave that is not in OP, its state and its AL status in words.
    """
    cycle()
    _request(master, OP)
    for attempt in range(attempts):
        cycle()
        # state_check is one datagram more and holds the interpreter: not in every cycle.
        if attempt % 10 == 0 and master.state_check(OP, _STEP_TIMEOUT_US) == OP:
            return
        if attempt % 100 == 99 and _acknowledge(master, SAFEOP):
            cycle()
            _request(master, OP)
    raise BusError(_laggards(master, specs, OP))


def reach_init(master: Master) -> int:
    """Request INIT, in which no slave holds outputs; returns the state that was found."""
    _request(master, INIT)
    return master.state_check(INIT, _STATE_TIMEOUT_US)


def _request(master: Master, state: int) -> None:
    master.state = state
    master.write_state()


def _acknowledge(master: Master, wanted: int) -> bool:
    """Acknowledge the error of every slave that has one (request of its present state with the flag set)."""
    master.read_state()
    slaves = [slave for slave in _slaves(master) if slave.state & ERROR]
    for slave in slaves:
        present = slave.state & 0x0F
        slave.state = present | ACK
        slave.write_state()
        slave.state_check(present, _STEP_TIMEOUT_US)
        slave.state = wanted
        slave.write_state()
    return bool(slaves)


def _slaves(master: Master) -> Sequence[Slave]:
    return master.slaves or ()


def _laggards(master: Master, specs: Sequence[SlaveSpec], wanted: int) -> str:
    master.read_state()
    late = [
        f"{spec.name} (position {spec.position}) is in {state_text(slave.state)}, "
        f"AL status {al_status_text(slave.al_status)}"
        for spec, slave in zip(specs, _slaves(master), strict=False)
        if slave.state != wanted
    ]
    who = "; ".join(late) if late else "every slave is there now, but later than allowed"
    return f"the bus did not reach {state_text(wanted)} in time: {who}"
