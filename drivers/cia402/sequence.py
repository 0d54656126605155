"""Lead a drive to a state, one control word a cycle: pure functions of what was asked for and what the drive says.

A sequence that has ended badly, or whose drive left the state it had reached, stays so and commands "disable voltage"
until somebody starts a new one: torque never comes back by itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np
from numpy.typing import NDArray

from drivers.cia402.states import STATE_BITS, Command, State, decode

_S, _C = State, Command


class Goal(Enum):
    """What a drive is to be led to."""

    DISABLED = auto()
    """No voltage: switch on disabled."""
    READY = auto()
    """Ready to switch on."""
    SWITCHED_ON = auto()
    """Power stage on, no torque."""
    ENABLED = auto()
    """Operation enabled: the drive follows its set values."""
    QUICK_STOP = auto()
    """Braked by the drive's own quick stop (0x605A)."""
    FAULT_RESET = auto()
    """Fault acknowledged: switch on disabled."""


class Outcome(Enum):
    """How far a sequence has come."""

    RUNNING = auto()
    REACHED = auto()
    FAULTED = auto()
    """The drive went into fault on the way or afterwards."""
    LEFT = auto()
    """The drive left the state it had reached: its own watchdog, safe torque off, an operator at the drive."""
    TIMED_OUT = auto()
    """The state was not reached within the cycles allowed."""


_OFF = _C.DISABLE_VOLTAGE
_UP_FROM_OFF: Mapping[State, Command] = {_S.SWITCH_ON_DISABLED: _C.SHUTDOWN, _S.QUICK_STOP_ACTIVE: _C.DISABLE_VOLTAGE}

COMMANDS: Mapping[Goal, Mapping[State, Command]] = {
    Goal.DISABLED: {},
    Goal.READY: {
        **_UP_FROM_OFF,
        _S.READY_TO_SWITCH_ON: _C.SHUTDOWN,
        _S.SWITCHED_ON: _C.SHUTDOWN,
        _S.OPERATION_ENABLED: _C.SHUTDOWN,
    },
    Goal.SWITCHED_ON: {
        **_UP_FROM_OFF,
        _S.READY_TO_SWITCH_ON: _C.SWITCH_ON,
        _S.SWITCHED_ON: _C.SWITCH_ON,
        _S.OPERATION_ENABLED: _C.SWITCH_ON,
    },
    Goal.ENABLED: {
        **_UP_FROM_OFF,
        _S.READY_TO_SWITCH_ON: _C.SWITCH_ON,
        _S.SWITCHED_ON: _C.ENABLE_OPERATION,
        _S.OPERATION_ENABLED: _C.ENABLE_OPERATION,
    },
    Goal.QUICK_STOP: {_S.OPERATION_ENABLED: _C.QUICK_STOP, _S.QUICK_STOP_ACTIVE: _C.QUICK_STOP},
    Goal.FAULT_RESET: {_S.FAULT: _C.FAULT_RESET},
}
"""Command by goal and present state; "disable voltage" in every state not listed. Quick stop active is left by
transition 12, never by 16: not every drive has 16, and it would bring torque back within one cycle."""

_NO_TORQUE = frozenset({_S.SWITCH_ON_DISABLED, _S.READY_TO_SWITCH_ON, _S.SWITCHED_ON, _S.NOT_READY_TO_SWITCH_ON})

REACHED: Mapping[Goal, frozenset[State]] = {
    Goal.DISABLED: frozenset({_S.SWITCH_ON_DISABLED, _S.NOT_READY_TO_SWITCH_ON, _S.FAULT}),
    Goal.READY: frozenset({_S.READY_TO_SWITCH_ON}),
    Goal.SWITCHED_ON: frozenset({_S.SWITCHED_ON}),
    Goal.ENABLED: frozenset({_S.OPERATION_ENABLED}),
    Goal.QUICK_STOP: _NO_TORQUE | {_S.QUICK_STOP_ACTIVE, _S.FAULT},
    Goal.FAULT_RESET: _NO_TORQUE,
}
"""States that fulfil a goal. A fault has no torque and so fulfils the goals that want none."""

_HOLDS = {
    goal: np.array([decode(bits) in states for bits in range(STATE_BITS + 1)], np.bool_)
    for goal, states in REACHED.items()
}
"""The same by the bits of the status word that hold the state, for blocks."""


@dataclass(frozen=True, slots=True)
class Sequence:
    """A way to a goal.

    Attributes
    ----------
    goal : what was asked for.
    timeout_cycles : cycles until it is given up.
    reset_hold_cycles : half period of the fault reset bit; the drive acts on its rising edge, seen in its own task.
    state : state of the drive as of the last step.
    controlword : what to send next.
    outcome : how far it has come; once not RUNNING or REACHED it stays.
    cycles : cycles since the start.
    """

    goal: Goal
    timeout_cycles: int
    reset_hold_cycles: int = 4
    state: State = State.UNKNOWN
    controlword: int = _OFF.controlword
    outcome: Outcome = Outcome.RUNNING
    cycles: int = 0


def begin(goal: Goal, timeout_cycles: int, state: State = State.UNKNOWN) -> Sequence:
    """Return a new sequence whose first control word suits the state the drive is in.

    Without that an enabled drive would be let loose for one cycle whenever something new is asked of it.
    """
    start = Sequence(goal, timeout_cycles, state=state)
    return replace(start, controlword=_controlword(start, state, start.outcome, 0, mode_matches=True))


def advance(sequence: Sequence, statusword: int, mode_matches: bool = True, cycles: int = 1) -> Sequence:
    """Return the sequence after the drive said ``statusword``.

    Parameters
    ----------
    statusword : 0x6041 of the last cycle.
    mode_matches : mode of operation display (0x6061) equals the mode asked for; operation is not enabled before.
    cycles : cycles since the last step (the length of a block).
    """
    state = decode(statusword)
    now = sequence.cycles + cycles
    outcome = _outcome(sequence, state, now)
    controlword = _controlword(sequence, state, outcome, now, mode_matches)
    hold = sequence.reset_hold_cycles
    return Sequence(sequence.goal, sequence.timeout_cycles, hold, state, controlword, outcome, now)


def holds(goal: Goal, statuswords: NDArray[np.uint16]) -> NDArray[np.bool_]:
    """Mask (n,) of the cycles in which the drive was in a state that fulfils the goal."""
    mask: NDArray[np.bool_] = _HOLDS[goal][statuswords & STATE_BITS]
    return mask


def _controlword(sequence: Sequence, state: State, outcome: Outcome, cycles: int, mode_matches: bool) -> int:
    """Control word for a goal in a state; the fault reset as a rising edge every two hold times."""
    command = COMMANDS[sequence.goal].get(state, _OFF)
    if outcome not in (Outcome.RUNNING, Outcome.REACHED):
        command = _OFF
    elif command is _C.ENABLE_OPERATION and state is _S.SWITCHED_ON and not mode_matches:
        command = _C.SWITCH_ON
    elif command is _C.FAULT_RESET and cycles // sequence.reset_hold_cycles % 2 == 0:
        command = _OFF
    return command.controlword


def _outcome(sequence: Sequence, state: State, cycles: int) -> Outcome:
    if sequence.outcome not in (Outcome.RUNNING, Outcome.REACHED):
        return sequence.outcome
    if state in REACHED[sequence.goal]:
        return Outcome.REACHED
    if state in (_S.FAULT, _S.FAULT_REACTION_ACTIVE) and sequence.goal is not Goal.FAULT_RESET:
        # Goals without torque wait for the fault reaction to end; the others have failed.
        return Outcome.RUNNING if state in _waits(sequence.goal) else Outcome.FAULTED
    if sequence.outcome is Outcome.REACHED:
        return Outcome.LEFT
    return Outcome.TIMED_OUT if cycles >= sequence.timeout_cycles else Outcome.RUNNING


def _waits(goal: Goal) -> frozenset[State]:
    return frozenset({_S.FAULT_REACTION_ACTIVE}) if _S.FAULT in REACHED[goal] else frozenset()
