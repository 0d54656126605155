"""The EtherCAT state machine of a slave: states, requests, AL status codes.

Source: ETG.1000.6 §6.4 and the table of AL status codes in ETG.1020. The table below says which request is served in
which state and which check comes before it; what the checks look at belongs to the slave.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import IntEnum


class AlState(IntEnum):
    """Application-layer states as they stand in AL control and AL status."""

    INIT = 0x01
    PREOP = 0x02
    BOOT = 0x03
    SAFEOP = 0x04
    OP = 0x08


ERROR = 0x10
"""AL status: error indication; AL control: acknowledge."""


class AlCode(IntEnum):
    """AL status codes these slaves can give."""

    NONE = 0x0000
    UNSPECIFIED = 0x0001
    INVALID_CHANGE = 0x0011
    UNKNOWN_STATE = 0x0012
    BOOT_NOT_SUPPORTED = 0x0013
    INVALID_MAILBOX = 0x0016
    INVALID_SYNC_MANAGERS = 0x0017
    WATCHDOG = 0x001B
    INVALID_OUTPUTS = 0x001D
    INVALID_INPUTS = 0x001E
    INVALID_INPUT_MAPPING = 0x0024
    INVALID_OUTPUT_MAPPING = 0x0025
    LOCAL_ERROR = 0x0050


_I, _P, _S, _O = AlState.INIT, AlState.PREOP, AlState.SAFEOP, AlState.OP

TRANSITIONS: dict[tuple[AlState, AlState], str] = {
    (_I, _I): "II",
    (_P, _P): "PP",
    (_S, _S): "SS",
    (_O, _O): "OO",
    (_I, _P): "IP",
    (_P, _I): "PI",
    (_P, _S): "PS",
    (_S, _P): "SP",
    (_S, _I): "SI",
    (_S, _O): "SO",
    (_O, _S): "OS",
    (_O, _P): "OP",
    (_O, _I): "OI",
}
"""Transitions a slave without BOOTSTRAP serves, by the standard's two-letter names."""

Check = Callable[[], AlCode]


class AlStateMachine:
    """State, error flag and status code; ``checks`` run before a transition, ``actions`` after it, by its name."""

    def __init__(self, checks: Mapping[str, Check], actions: Mapping[str, Callable[[], None]]) -> None:
        self.state = AlState.INIT
        self.code = AlCode.NONE
        self._checks = checks
        self._actions = actions

    @property
    def status(self) -> int:
        """AL status register 0x0130: state and error flag."""
        return int(self.state) | (ERROR if self.code else 0)

    def request(self, control: int) -> None:
        """Serve a write to AL control 0x0120.

        While the error flag is set, a request for a higher state is served only if it acknowledges the error.
        """
        if control & ERROR:
            self.code = AlCode.NONE
        elif self.code and (control & 0x0F) > self.state:
            return
        try:
            target = AlState(control & 0x0F)
        except ValueError:
            self.code = AlCode.UNKNOWN_STATE
            return
        if target is AlState.BOOT:
            self.code = AlCode.BOOT_NOT_SUPPORTED
            return
        transition = TRANSITIONS.get((self.state, target))
        if transition is None:
            self.code = AlCode.INVALID_CHANGE
            return
        code = self._checks[transition]() if transition in self._checks else AlCode.NONE
        if code:
            self.code = code
            return
        self._enter(target, transition)

    def fall_back(self, target: AlState, code: AlCode) -> None:
        """Leave for a lower state by the slave's own decision, with the reason (a watchdog, a local error)."""
        transition = TRANSITIONS[self.state, target]
        self.code = code
        self._enter(target, transition)

    def _enter(self, target: AlState, transition: str) -> None:
        self.state = target
        if transition in self._actions:
            self._actions[transition]()
