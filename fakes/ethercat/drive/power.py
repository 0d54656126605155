"""The power stage of a drive: which state it is in, what it ramps down to, which fault it has.

Pure state without arrays or dictionary; :class:`~fakes.ethercat.slaves.servo.ServoDrive` asks it cycle
by cycle or run by run.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fakes.ethercat.drive.cia402 import Bit, State, Transition, transition

QUICK_STOP_OPTION, SHUTDOWN_OPTION, DISABLE_OPTION, REACTION_OPTION = 0x605A, 0x605B, 0x605C, 0x605E

_OPTION = {5: DISABLE_OPTION, 8: SHUTDOWN_OPTION, 11: QUICK_STOP_OPTION}
"""Transitions that may ramp down first, and the option code that says so; 0 drops the torque at once."""

_STAYS = 5
"""Quick stop option codes from here on stay in QUICK STOP ACTIVE."""


@dataclass(slots=True)
class PowerStage:
    """State of the drive.

    ``target`` is the state that follows a ramp under way (None: no ramp), ``ramp_cycles`` how long it has lasted,
    ``control_word`` that of the cycle before.
    """

    state: State = State.SWITCH_ON_DISABLED
    error_code: int = 0
    safe_torque_off: bool = False
    target: State | None = None
    ramp_cycles: int = 0
    control_word: int = 0

    @property
    def powered(self) -> bool:
        """Whether the motor carries torque."""
        # Not a set of states: hashing an enum takes longer than all three comparisons, and this is asked every cycle.
        return self.state is State.ENABLED or self.state is State.QUICK_STOP or self.state is State.FAULT_REACTION

    @property
    def stopping(self) -> bool:
        """Whether the drive brakes or holds by itself, whatever its set value."""
        return self.powered and (self.state is not State.ENABLED or self.target is not None)

    def command(self, control_word: int, option: Callable[[int], int]) -> Transition | None:
        """Serve the control word of one cycle; return the transition it started, if any.

        ``option`` returns the value of an option code object.
        """
        found = transition(self.state, control_word, self.control_word)
        self.control_word = control_word
        if found is None or (self.safe_torque_off and found.number == 2):
            return None
        if self.target is not None and self.state is State.ENABLED and found.number in _OPTION and found.number != 11:
            return None  # already ramping down
        ramp = option(_OPTION[found.number]) if found.number in _OPTION else 0
        if found.number == 16 and option(QUICK_STOP_OPTION) < _STAYS:
            return None
        if found.number == 11:
            self._enter(State.QUICK_STOP if ramp else State.SWITCH_ON_DISABLED)
            if 0 < ramp < _STAYS:
                self.target = State.SWITCH_ON_DISABLED
        elif ramp:
            self.target, self.ramp_cycles = found.target, 0
        else:
            self._enter(found.target)
        if found.number == 15:
            self.error_code = 0
        return found

    def fail(self, code: int, option: Callable[[int], int]) -> bool:
        """Take a fault (transition 13); return whether it is a new one."""
        if self.state in (State.FAULT, State.FAULT_REACTION):
            return False
        self.error_code = code
        if self.powered and option(REACTION_OPTION) > 0:
            self._enter(State.FAULT_REACTION)
            self.target = State.FAULT
        else:
            self._enter(State.FAULT)
        return True

    def set_safe_torque_off(self, active: bool) -> None:
        """Cut the torque by the safety input; the drive cannot leave SWITCH ON DISABLED while it is requested."""
        self.safe_torque_off = active
        if active:
            failed = self.state in (State.FAULT, State.FAULT_REACTION)
            self._enter(State.FAULT if failed else State.SWITCH_ON_DISABLED)

    def standstill(self) -> None:
        """End a ramp: the state that was to follow is entered (transitions 12 and 14 among them)."""
        if self.target is not None:
            self._enter(self.target)

    def status_word(self) -> int:
        """Return 0x6041 without the bits that depend on measurements."""
        word = self.state.value | Bit.REMOTE
        if not self.safe_torque_off:
            word |= Bit.VOLTAGE_ENABLED
        if self.state is State.ENABLED and self.target is None:
            word |= Bit.FOLLOWS_COMMAND
        return word

    def _enter(self, state: State) -> None:
        self.state, self.target, self.ramp_cycles = state, None, 0
