"""The power drive system's state machine (CiA 402-2 / IEC 61800-7-201, figure 3) as tables."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray


class State(IntEnum):
    """States of the power drive system; ``UNKNOWN`` where the status word matches none."""

    UNKNOWN = 0
    NOT_READY_TO_SWITCH_ON = 1
    SWITCH_ON_DISABLED = 2
    READY_TO_SWITCH_ON = 3
    SWITCHED_ON = 4
    OPERATION_ENABLED = 5
    QUICK_STOP_ACTIVE = 6
    FAULT_REACTION_ACTIVE = 7
    FAULT = 8

    @property
    def text(self) -> str:
        """Name as the standard writes it, in lower case."""
        return self.name.lower().replace("_", " ")


STATUS_PATTERNS: tuple[tuple[State, int, int], ...] = (
    (State.NOT_READY_TO_SWITCH_ON, 0x4F, 0x00),
    (State.SWITCH_ON_DISABLED, 0x4F, 0x40),
    (State.READY_TO_SWITCH_ON, 0x6F, 0x21),
    (State.SWITCHED_ON, 0x6F, 0x23),
    (State.OPERATION_ENABLED, 0x6F, 0x27),
    (State.QUICK_STOP_ACTIVE, 0x6F, 0x07),
    (State.FAULT_REACTION_ACTIVE, 0x4F, 0x0F),
    (State.FAULT, 0x4F, 0x08),
)
"""Status word 0x6041: state, mask, value."""

STATE_BITS = 0x6F
"""Bits of the status word that hold the state."""

_LOOKUP = np.zeros(STATE_BITS + 1, np.uint8)
for _state, _mask, _value in STATUS_PATTERNS:
    _LOOKUP[np.arange(STATE_BITS + 1) & _mask == _value] = _state
_STATES = tuple(State(int(number)) for number in _LOOKUP)


def decode(statusword: int) -> State:
    """State of one status word (0x6041)."""
    return _STATES[statusword & STATE_BITS]


def decode_block(statuswords: ArrayLike) -> NDArray[np.uint8]:
    """States (n,), as :class:`State` numbers, of status words (n,)."""
    return _LOOKUP[np.bitwise_and(np.asarray(statuswords, np.uint16), STATE_BITS)]


class Command(Enum):
    """Commands of the control word 0x6040: (mask of the bits that count, their value)."""

    SHUTDOWN = (0x87, 0x06)
    SWITCH_ON = (0x8F, 0x07)
    ENABLE_OPERATION = (0x8F, 0x0F)
    DISABLE_VOLTAGE = (0x82, 0x00)
    QUICK_STOP = (0x86, 0x02)
    FAULT_RESET = (0x80, 0x80)

    @property
    def controlword(self) -> int:
        """Control word that gives this command and nothing else."""
        return self.value[1]


@dataclass(frozen=True, slots=True)
class Transition:
    """One edge of the state machine.

    Attributes
    ----------
    number : the standard's number, 0–16.
    source, target : states; the source of 0 is power-on, here ``UNKNOWN``; 13 starts from any state.
    commands : commands that cause it; empty where the drive takes it by itself.
    """

    number: int
    source: State | None
    target: State
    commands: tuple[Command, ...] = ()


_S, _C = State, Command

TRANSITIONS: tuple[Transition, ...] = (
    Transition(0, _S.UNKNOWN, _S.NOT_READY_TO_SWITCH_ON),
    Transition(1, _S.NOT_READY_TO_SWITCH_ON, _S.SWITCH_ON_DISABLED),
    Transition(2, _S.SWITCH_ON_DISABLED, _S.READY_TO_SWITCH_ON, (_C.SHUTDOWN,)),
    Transition(3, _S.READY_TO_SWITCH_ON, _S.SWITCHED_ON, (_C.SWITCH_ON, _C.ENABLE_OPERATION)),
    Transition(4, _S.SWITCHED_ON, _S.OPERATION_ENABLED, (_C.ENABLE_OPERATION,)),
    Transition(5, _S.OPERATION_ENABLED, _S.SWITCHED_ON, (_C.SWITCH_ON,)),
    Transition(6, _S.SWITCHED_ON, _S.READY_TO_SWITCH_ON, (_C.SHUTDOWN,)),
    Transition(7, _S.READY_TO_SWITCH_ON, _S.SWITCH_ON_DISABLED, (_C.DISABLE_VOLTAGE, _C.QUICK_STOP)),
    Transition(8, _S.OPERATION_ENABLED, _S.READY_TO_SWITCH_ON, (_C.SHUTDOWN,)),
    Transition(9, _S.OPERATION_ENABLED, _S.SWITCH_ON_DISABLED, (_C.DISABLE_VOLTAGE,)),
    Transition(10, _S.SWITCHED_ON, _S.SWITCH_ON_DISABLED, (_C.DISABLE_VOLTAGE, _C.QUICK_STOP)),
    Transition(11, _S.OPERATION_ENABLED, _S.QUICK_STOP_ACTIVE, (_C.QUICK_STOP,)),
    Transition(12, _S.QUICK_STOP_ACTIVE, _S.SWITCH_ON_DISABLED, (_C.DISABLE_VOLTAGE,)),
    Transition(13, None, _S.FAULT_REACTION_ACTIVE),
    Transition(14, _S.FAULT_REACTION_ACTIVE, _S.FAULT),
    Transition(15, _S.FAULT, _S.SWITCH_ON_DISABLED, (_C.FAULT_RESET,)),
    Transition(16, _S.QUICK_STOP_ACTIVE, _S.OPERATION_ENABLED, (_C.ENABLE_OPERATION,)),
)
"""Every transition. The command of 5 is "disable operation", whose control word is that of "switch on" (0x0007).
12 also happens by itself when a quick stop of option 1–3 ends; 15 needs the rising edge of bit 7."""


def transition(source: State, target: State) -> Transition | None:
    """Return the transition between two states, or None where the standard has none."""
    for edge in TRANSITIONS:
        if edge.target is target and edge.source in (source, None):
            return edge
    return None
