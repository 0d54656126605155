"""The driver's table and the emulated drive's were written apart; here they meet."""

from drivers.cia402 import State as Ours
from drivers.cia402.states import STATUS_PATTERNS, TRANSITIONS
from drivers.cia402.states import Command as OurCommand
from fakes.ethercat.drive.cia402 import TRANSITIONS as THEIR_TRANSITIONS
from fakes.ethercat.drive.cia402 import Command as TheirCommand
from fakes.ethercat.drive.cia402 import State as Theirs

PATTERN = {state: value for state, _, value in STATUS_PATTERNS}


def test_the_same_states_have_the_same_bits() -> None:
    assert {state.value for state in Theirs} == set(PATTERN.values())


def test_the_same_commands_have_the_same_bits() -> None:
    assert {command.name: command.value for command in OurCommand} == {c.name: c.value for c in TheirCommand}


def test_the_same_commands_cause_the_same_transitions() -> None:
    ours = {
        (edge.number, PATTERN[Ours(edge.source)], command.name, PATTERN[edge.target])
        for edge in TRANSITIONS
        for command in edge.commands
        if edge.source is not None
    }
    theirs = {(t.number, t.source.value, t.command.name, t.target.value) for t in THEIR_TRANSITIONS}
    assert ours == theirs
