"""The CiA 402 power drive state machine, written from IEC 61800-7-201 §6.1.

The table is this package's own: the driver keeps another, and a test compares both with python-canopen's, so that one
mistake cannot hide in both.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum


class State(Enum):
    """States of the drive; the value is the pattern of status word bits 0, 1, 2, 3, 5 and 6."""

    NOT_READY = 0x00
    SWITCH_ON_DISABLED = 0x40
    READY = 0x21
    SWITCHED_ON = 0x23
    ENABLED = 0x27
    QUICK_STOP = 0x07
    FAULT_REACTION = 0x0F
    FAULT = 0x08


class Command(Enum):
    """What a control word asks for: (mask, pattern) of bits 0-3 and 7."""

    SHUTDOWN = (0x87, 0x06)
    SWITCH_ON = (0x8F, 0x07)
    ENABLE_OPERATION = (0x8F, 0x0F)
    DISABLE_VOLTAGE = (0x82, 0x00)
    QUICK_STOP = (0x86, 0x02)
    FAULT_RESET = (0x80, 0x80)


@dataclass(frozen=True, slots=True)
class Transition:
    """One transition on command, with the number the standard gives it."""

    number: int
    source: State
    command: Command
    target: State


_C, _S = Command, State

TRANSITIONS: tuple[Transition, ...] = (
    Transition(2, _S.SWITCH_ON_DISABLED, _C.SHUTDOWN, _S.READY),
    Transition(3, _S.READY, _C.SWITCH_ON, _S.SWITCHED_ON),
    Transition(3, _S.READY, _C.ENABLE_OPERATION, _S.SWITCHED_ON),
    Transition(4, _S.SWITCHED_ON, _C.ENABLE_OPERATION, _S.ENABLED),
    Transition(5, _S.ENABLED, _C.SWITCH_ON, _S.SWITCHED_ON),
    Transition(6, _S.SWITCHED_ON, _C.SHUTDOWN, _S.READY),
    Transition(7, _S.READY, _C.QUICK_STOP, _S.SWITCH_ON_DISABLED),
    Transition(7, _S.READY, _C.DISABLE_VOLTAGE, _S.SWITCH_ON_DISABLED),
    Transition(8, _S.ENABLED, _C.SHUTDOWN, _S.READY),
    Transition(9, _S.ENABLED, _C.DISABLE_VOLTAGE, _S.SWITCH_ON_DISABLED),
    Transition(10, _S.SWITCHED_ON, _C.DISABLE_VOLTAGE, _S.SWITCH_ON_DISABLED),
    Transition(10, _S.SWITCHED_ON, _C.QUICK_STOP, _S.SWITCH_ON_DISABLED),
    Transition(11, _S.ENABLED, _C.QUICK_STOP, _S.QUICK_STOP),
    Transition(12, _S.QUICK_STOP, _C.DISABLE_VOLTAGE, _S.SWITCH_ON_DISABLED),
    Transition(15, _S.FAULT, _C.FAULT_RESET, _S.SWITCH_ON_DISABLED),
    Transition(16, _S.QUICK_STOP, _C.ENABLE_OPERATION, _S.ENABLED),
)
"""Transitions on command. Automatic ones: 0 and 1 (power on, self test done), 13 (fault), 14 (fault reaction done)."""

_BY_SOURCE: dict[State, tuple[Transition, ...]] = {
    state: tuple(t for t in TRANSITIONS if t.source is state) for state in State
}


def transition(state: State, control_word: int, previous: int) -> Transition | None:
    """Return the transition a control word triggers, or None.

    A fault reset needs a rising edge of bit 7, so the control word of the cycle before is looked at too.
    """
    for candidate in _BY_SOURCE[state]:
        mask, pattern = candidate.command.value
        if control_word & mask != pattern:
            continue
        if candidate.command is Command.FAULT_RESET and previous & 0x80:
            continue
        return candidate
    return None


class Bit(IntEnum):
    """Status word bits beyond the state pattern."""

    VOLTAGE_ENABLED = 0x0010
    WARNING = 0x0080
    REMOTE = 0x0200
    TARGET_REACHED = 0x0400
    INTERNAL_LIMIT = 0x0800
    FOLLOWS_COMMAND = 0x1000


class Mode(IntEnum):
    """Modes of operation (0x6060) these drives have."""

    NONE = 0
    CSP = 8
    CSV = 9
    CST = 10


SUPPORTED_MODES = 1 << (Mode.CSV - 1) | 1 << (Mode.CST - 1)
"""0x6502: bit n stands for mode n + 1."""
