"""Bring slaves back that left OP or the bus, one bounded step at a call."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from drivers.ethercat.codes import al_status_text, state_text
from drivers.ethercat.protocols import ACK, ERROR, OP, PREOP, SAFEOP, Master, Slave
from drivers.ethercat.slave import SlaveSpec

_TIMEOUT_US = 500


class Condition(Enum):
    """What a slave was found in, and so what was tried."""

    OPERATIONAL = "operational"
    LOST = "does not answer"
    ERROR = "fell back with an error, which was acknowledged"
    SAFE = "in SAFEOP, OP was requested"
    RECONFIGURED = "came back without its settings and was configured again"
    FAILED = "came back but could not be configured"


@dataclass(frozen=True, slots=True)
class Recovery:
    """One slave after one step of recovery.

    Attributes
    ----------
    name : the slave.
    condition : what it was found in.
    text : sentence with its state and AL status.
    """

    name: str
    condition: Condition
    text: str


def recover_step(master: Master, specs: Sequence[SlaveSpec]) -> tuple[Recovery, ...]:
    """Look at every slave once and take one step towards OP for each that is not there.

    One call costs some milliseconds of bus time at most for each slave that is lost; the caller decides how often it is
    worth it. pysoem never sets ``is_lost`` by itself, which is why it is set here.
    """
    master.read_state()
    return tuple(_describe(spec, slave, _step(slave)) for spec, slave in zip(specs, master.slaves or (), strict=False))


def _step(slave: Slave) -> Condition:
    state = slave.state
    if slave.is_lost or state & 0x0F == 0:
        return _find(slave)
    if state == OP:
        return Condition.OPERATIONAL
    if state & ERROR:
        slave.state = (state & 0x0F) | ACK
        slave.write_state()
        return Condition.ERROR
    if state == SAFEOP:
        slave.state = OP
        slave.write_state()
        return Condition.SAFE
    return _reconfigure(slave)


def _find(slave: Slave) -> Condition:
    if slave.state & 0x0F == 0 and slave.recover(_TIMEOUT_US) <= 0:
        slave.is_lost = True
        return Condition.LOST
    slave.is_lost = False
    return _reconfigure(slave)


def _reconfigure(slave: Slave) -> Condition:
    """INIT or PREOP: SDO settings are gone, ``reconfig`` runs the configuration function again on the way to SAFEOP."""
    reached = slave.reconfig(_TIMEOUT_US)
    if reached & 0x0F < PREOP:
        return Condition.FAILED
    return Condition.RECONFIGURED


def _describe(spec: SlaveSpec, slave: Slave, condition: Condition) -> Recovery:
    text = (
        f"{spec.name} (position {spec.position}) {condition.value}: {state_text(slave.state)}, "
        f"AL status {al_status_text(slave.al_status)}"
    )
    return Recovery(spec.name, condition, text)
