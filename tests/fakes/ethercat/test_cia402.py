"""The drive's state machine against python-canopen's table and the standard's rules."""

from __future__ import annotations

import pytest
from canopen.profiles.p402 import State402

from fakes.ethercat.drive.cia402 import TRANSITIONS, Command, State, transition
from fakes.ethercat.drive.power import PowerStage

NAMES = {
    State.NOT_READY: "NOT READY TO SWITCH ON",
    State.SWITCH_ON_DISABLED: "SWITCH ON DISABLED",
    State.READY: "READY TO SWITCH ON",
    State.SWITCHED_ON: "SWITCHED ON",
    State.ENABLED: "OPERATION ENABLED",
    State.QUICK_STOP: "QUICK STOP ACTIVE",
    State.FAULT_REACTION: "FAULT REACTION ACTIVE",
    State.FAULT: "FAULT",
}


@pytest.mark.parametrize("state", list(State))
def test_status_word_pattern_is_the_one_canopen_looks_for(state):
    word = PowerStage(state=state).status_word()
    matching = [name for name, (mask, value) in State402.SW_MASK.items() if word & mask == value]
    assert matching == [NAMES[state]]


def test_every_transition_canopen_knows_is_served_with_its_control_word():
    automatic = {("NOT READY TO SWITCH ON", "SWITCH ON DISABLED"), ("START", "NOT READY TO SWITCH ON")}
    automatic.add(("FAULT REACTION ACTIVE", "FAULT"))
    by_name = {name: state for state, name in NAMES.items()}
    for (source, target), word in State402.TRANSITIONTABLE.items():
        if (source, target) in automatic:
            continue
        found = transition(by_name[source], word, previous=0)
        assert found is not None, (source, target)
        # from READY, ENABLE OPERATION passes through SWITCHED ON; everything else goes straight
        assert NAMES[found.target] == target, (source, target, found)


def test_no_transition_that_canopen_does_not_know():
    known = set(State402.TRANSITIONTABLE)
    for found in TRANSITIONS:
        assert (NAMES[found.source], NAMES[found.target]) in known


def test_numbers_are_the_standards():
    """IEC 61800-7-201: each number stands for one pair of states."""
    pairs = {}
    for found in TRANSITIONS:
        pairs.setdefault(found.number, set()).add((found.source, found.target))
    assert sorted(pairs) == [2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 15, 16]
    assert all(len(found) == 1 for found in pairs.values())


def test_commands_are_told_apart_by_their_bits():
    for word in range(256):
        assert sum(word & c.value[0] == c.value[1] for c in Command) <= 1, hex(word)


def option(**values):
    defaults = {"quick_stop": 2, "shutdown": 0, "disable": 1, "reaction": 2, **values}
    codes = dict(zip((0x605A, 0x605B, 0x605C, 0x605E), defaults.values(), strict=True))
    return codes.__getitem__


def test_fault_reset_needs_a_rising_edge():
    stage = PowerStage(state=State.FAULT, error_code=0x2310, control_word=0x80)
    assert stage.command(0x80, option()) is None
    assert stage.command(0x00, option()) is None
    assert stage.command(0x80, option()).number == 15
    assert (stage.state, stage.error_code) == (State.SWITCH_ON_DISABLED, 0)


def test_quick_stop_ramps_and_then_switches_off():
    stage = PowerStage(state=State.ENABLED)
    assert stage.command(0x02, option()).number == 11
    assert (stage.state, stage.stopping, stage.powered) == (State.QUICK_STOP, True, True)
    stage.standstill()
    assert stage.state is State.SWITCH_ON_DISABLED


def test_quick_stop_that_stays_can_be_left_by_enable():
    stage = PowerStage(state=State.ENABLED)
    stage.command(0x02, option(quick_stop=6))
    stage.standstill()
    assert stage.state is State.QUICK_STOP
    assert stage.command(0x0F, option(quick_stop=6)).number == 16
    assert stage.state is State.ENABLED


def test_quick_stop_that_switches_off_cannot_be_left_by_enable():
    stage = PowerStage(state=State.ENABLED)
    stage.command(0x02, option())
    assert stage.command(0x0F, option()) is None


def test_disable_operation_ramps_first_but_disable_voltage_does_not():
    stage = PowerStage(state=State.ENABLED)
    assert stage.command(0x07, option()).number == 5
    assert (stage.state, stage.stopping) == (State.ENABLED, True)
    assert stage.command(0x07, option()) is None
    assert stage.command(0x00, option()).number == 9
    assert not stage.powered


@pytest.mark.parametrize("state", [State.ENABLED, State.QUICK_STOP])
def test_fault_in_a_powered_state_reacts_first(state):
    stage = PowerStage(state=state)
    assert stage.fail(0x3210, option())
    assert stage.state is State.FAULT_REACTION
    assert not stage.fail(0x2310, option())
    assert stage.error_code == 0x3210
    stage.standstill()
    assert stage.state is State.FAULT


def test_fault_without_reaction_drops_the_torque_at_once():
    stage = PowerStage(state=State.ENABLED)
    stage.fail(0x3210, option(reaction=0))
    assert stage.state is State.FAULT


def test_safe_torque_off_holds_the_drive_off():
    stage = PowerStage(state=State.ENABLED)
    stage.set_safe_torque_off(True)
    assert stage.state is State.SWITCH_ON_DISABLED
    assert stage.status_word() & 0x10 == 0
    assert stage.command(0x06, option()) is None
    stage.set_safe_torque_off(False)
    assert stage.command(0x06, option()).number == 2
