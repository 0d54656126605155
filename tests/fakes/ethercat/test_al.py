"""The EtherCAT state machine, every pair of states."""

from __future__ import annotations

import pytest

from fakes.ethercat.slaves.al import ERROR, TRANSITIONS, AlCode, AlState, AlStateMachine

REAL = (AlState.INIT, AlState.PREOP, AlState.SAFEOP, AlState.OP)


def machine(state=AlState.INIT, **checks):
    made = AlStateMachine({name: (lambda code=code: code) for name, code in checks.items()}, {})
    made.state = state
    return made


@pytest.mark.parametrize("source", REAL)
@pytest.mark.parametrize("target", REAL)
def test_upwards_one_step_at_a_time_downwards_any(source, target):
    allowed = REAL.index(target) <= REAL.index(source) + 1
    made = machine(source)
    made.request(int(target))
    if allowed:
        assert (made.status, made.code) == (int(target), AlCode.NONE)
        assert (source, target) in TRANSITIONS
    else:
        assert (made.status, made.code) == (int(source) | ERROR, AlCode.INVALID_CHANGE)


@pytest.mark.parametrize("source", REAL)
@pytest.mark.parametrize(("asked", "code"), [(0x03, AlCode.BOOT_NOT_SUPPORTED), (0x07, AlCode.UNKNOWN_STATE)])
def test_states_there_are_not(source, asked, code):
    made = machine(source)
    made.request(asked)
    assert (made.status, made.code) == (int(source) | ERROR, code)


def test_a_check_that_fails_keeps_the_state_until_acknowledged():
    made = machine(AlState.PREOP, PS=AlCode.INVALID_OUTPUTS)
    made.request(AlState.SAFEOP)
    assert (made.status, made.code) == (0x12, AlCode.INVALID_OUTPUTS)
    made.request(AlState.SAFEOP)
    assert made.status == 0x12
    made.request(AlState.PREOP | ERROR)
    assert (made.status, made.code) == (0x02, AlCode.NONE)


def test_falling_back_shows_why():
    made = machine(AlState.OP)
    made.fall_back(AlState.SAFEOP, AlCode.WATCHDOG)
    assert (made.status, made.code) == (0x14, AlCode.WATCHDOG)
    made.request(AlState.OP)
    assert made.status == 0x14
    made.request(AlState.SAFEOP | ERROR)
    made.request(AlState.OP)
    assert made.status == 0x08


def test_actions_follow_the_transition():
    done = []
    made = AlStateMachine({}, {"IP": lambda: done.append("IP"), "OS": lambda: done.append("OS")})
    made.request(AlState.PREOP)
    made.request(AlState.SAFEOP)
    made.request(AlState.OP)
    made.fall_back(AlState.SAFEOP, AlCode.WATCHDOG)
    assert done == ["IP", "OS"]
