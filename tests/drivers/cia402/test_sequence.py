"""Every goal from every state, against a drive built from python-canopen's transition table."""

from __future__ import annotations

import itertools

import pytest
from canopen.profiles.p402 import State402
from hypothesis import given
from hypothesis import strategies as st

from drivers.cia402 import Goal, Outcome, State, advance, begin
from drivers.cia402.sequence import REACHED
from drivers.cia402.states import Command, decode

STATES = [state for state in State if state is not State.UNKNOWN]
WORDS = {state: State402.SW_MASK[state.text.upper()][1] for state in STATES}
ENABLE = Command.ENABLE_OPERATION.controlword


class Drive:
    """Follows canopen's table, one transition a cycle."""

    def __init__(self, state: State, quick_stop_stays: bool = True) -> None:
        self.state = state
        self.last = 0
        self.stays = quick_stop_stays
        self.stuck = False

    @property
    def statusword(self) -> int:
        return WORDS[self.state]

    def cycle(self, controlword: int) -> None:
        last, self.last = self.last, controlword
        if self.stuck:
            return
        if self.state is State.FAULT:
            if controlword & 0x80 and not last & 0x80:
                self.state = State.SWITCH_ON_DISABLED
            return
        for (source, target), command in State402.TRANSITIONTABLE.items():
            if source != self.state.text.upper():
                continue
            mask = 0x8F if controlword & 0x02 and controlword & 0x04 else 0x86
            automatic = command == 0 and source in ("NOT READY TO SWITCH ON", "FAULT REACTION ACTIVE")
            if automatic or (command & mask == controlword & mask and self._commands(command, controlword)):
                self.state = next(state for state in STATES if state.text.upper() == target)
                return
        if self.state is State.QUICK_STOP_ACTIVE and not self.stays:
            self.state = State.SWITCH_ON_DISABLED

    @staticmethod
    def _commands(command: int, controlword: int) -> bool:
        """Disable voltage looks at bit 1 alone, quick stop at bits 1 and 2."""
        if not controlword & 0x02:
            return command == State402.CW_DISABLE_VOLTAGE
        if not controlword & 0x04:
            return command == State402.CW_QUICK_STOP
        return command == controlword & 0x0F


def run(goal: Goal, drive: Drive, cycles: int = 40, timeout: int = 30) -> tuple[Outcome, list[int]]:
    sequence = begin(goal, timeout, decode(drive.statusword))
    sent = []
    for _ in range(cycles):
        sent.append(sequence.controlword)
        drive.cycle(sequence.controlword)
        sequence = advance(sequence, drive.statusword)
    return sequence.outcome, sent


def expected(goal: Goal, start: State) -> Outcome:
    wants_torque_path = goal in (Goal.READY, Goal.SWITCHED_ON, Goal.ENABLED)
    if start in (State.FAULT, State.FAULT_REACTION_ACTIVE) and wants_torque_path:
        return Outcome.FAULTED
    return Outcome.REACHED


@pytest.mark.parametrize("goal", list(Goal))
@pytest.mark.parametrize("start", STATES)
def test_every_goal_from_every_state(goal: Goal, start: State) -> None:
    if goal is Goal.FAULT_RESET and start in (State.QUICK_STOP_ACTIVE, State.OPERATION_ENABLED):
        drive = Drive(start)
        outcome, sent = run(goal, drive)
        assert drive.state is State.SWITCH_ON_DISABLED
        assert ENABLE not in sent
        return
    drive = Drive(start)
    outcome, sent = run(goal, drive)
    assert outcome is expected(goal, start)
    if outcome is Outcome.REACHED:
        assert drive.state in REACHED[goal]
    if goal is not Goal.ENABLED or outcome is Outcome.FAULTED:
        assert ENABLE not in sent


@pytest.mark.parametrize("goal", [goal for goal in Goal if goal is not Goal.FAULT_RESET])
def test_no_goal_but_the_reset_resets_a_fault(goal: Goal) -> None:
    drive = Drive(State.FAULT)
    _, sent = run(goal, drive)
    assert drive.state is State.FAULT
    assert all(not word & 0x80 for word in sent)


def test_the_way_up_is_two_three_four() -> None:
    outcome, sent = run(Goal.ENABLED, Drive(State.SWITCH_ON_DISABLED))
    assert outcome is Outcome.REACHED
    assert sent[:4] == [0x06, 0x07, 0x0F, 0x0F]


def test_an_enabled_drive_is_not_let_loose_when_asked_again() -> None:
    _, sent = run(Goal.ENABLED, Drive(State.OPERATION_ENABLED))
    assert set(sent) == {0x0F}
    _, sent = run(Goal.QUICK_STOP, Drive(State.OPERATION_ENABLED))
    assert set(sent) == {0x02}


@pytest.mark.parametrize("stays", [True, False])
def test_quick_stop_counts_as_reached_whether_the_drive_stays_in_it_or_not(stays: bool) -> None:
    outcome, sent = run(Goal.QUICK_STOP, Drive(State.OPERATION_ENABLED, stays))
    assert outcome is Outcome.REACHED
    assert ENABLE not in sent


def test_fault_reset_gives_rising_edges_only_until_it_works() -> None:
    drive = Drive(State.FAULT)
    drive.stuck = True
    outcome, sent = run(Goal.FAULT_RESET, drive)
    assert outcome is Outcome.TIMED_OUT
    edges = sum(b & 0x80 > a & 0x80 for a, b in itertools.pairwise(sent))
    assert 3 <= edges <= 5  # once every eight cycles of the thirty allowed
    assert sent[-5:] == [0] * 5


def test_enable_waits_for_the_mode() -> None:
    sequence = begin(Goal.ENABLED, 100, State.SWITCH_ON_DISABLED)
    drive = Drive(State.SWITCH_ON_DISABLED)
    for _ in range(10):
        drive.cycle(sequence.controlword)
        sequence = advance(sequence, drive.statusword, mode_matches=False)
    assert drive.state is State.SWITCHED_ON
    drive.cycle(sequence.controlword)
    sequence = advance(sequence, drive.statusword, mode_matches=True)
    drive.cycle(sequence.controlword)
    assert advance(sequence, drive.statusword).outcome is Outcome.REACHED


def test_a_drive_that_leaves_is_not_enabled_again() -> None:
    sequence = begin(Goal.ENABLED, 100, State.OPERATION_ENABLED)
    sequence = advance(sequence, WORDS[State.OPERATION_ENABLED])
    assert sequence.outcome is Outcome.REACHED
    sequence = advance(sequence, WORDS[State.SWITCH_ON_DISABLED])
    assert (sequence.outcome, sequence.controlword) == (Outcome.LEFT, 0)


@given(
    goal=st.sampled_from(list(Goal)),
    words=st.lists(st.integers(0, 0xFFFF), max_size=60),
    start=st.sampled_from(list(State)),
    timeout=st.integers(1, 20),
)
def test_whatever_a_drive_says_torque_needs_a_living_request(
    goal: Goal, words: list[int], start: State, timeout: int
) -> None:
    sequence = begin(goal, timeout, start)
    ended = False
    for word in words:
        sequence = advance(sequence, word)
        ended = ended or sequence.outcome not in (Outcome.RUNNING, Outcome.REACHED)
        if ended:
            assert sequence.outcome not in (Outcome.RUNNING, Outcome.REACHED)
            assert sequence.controlword == 0
        if sequence.controlword == ENABLE:
            assert goal is Goal.ENABLED
            assert sequence.state in (State.SWITCHED_ON, State.OPERATION_ENABLED)
        if sequence.controlword & 0x80:
            assert goal is Goal.FAULT_RESET
            assert sequence.state is State.FAULT


@given(st.integers(1, 50))
def test_time_runs_out_after_the_cycles_allowed(timeout: int) -> None:
    sequence = begin(Goal.ENABLED, timeout)
    for cycle in range(1, timeout + 3):
        sequence = advance(sequence, WORDS[State.READY_TO_SWITCH_ON])
        assert (sequence.outcome is Outcome.TIMED_OUT) == (cycle >= timeout)
