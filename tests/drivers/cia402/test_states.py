import itertools

import numpy as np
from canopen.profiles.p402 import OperationMode, State402
from hypothesis import given
from hypothesis import strategies as st

from drivers.cia402 import Mode, State, decode, decode_block
from drivers.cia402.states import STATUS_PATTERNS, TRANSITIONS, Command, transition

CANOPEN = {state: name for name in State402.SW_MASK for state in State if state.text == name.lower()}


def canopen_state(statusword: int) -> State:
    """Decode as python-canopen does."""
    for name, (mask, value) in State402.SW_MASK.items():
        if statusword & mask == value:
            return next(state for state, text in CANOPEN.items() if text == name)
    return State.UNKNOWN


def test_the_two_tables_name_the_same_states() -> None:
    assert set(CANOPEN.values()) == set(State402.SW_MASK)
    assert len(CANOPEN) == len(STATUS_PATTERNS) == 8


def test_every_status_word_decodes_as_in_canopen() -> None:
    words = np.arange(1 << 16, dtype=np.uint16)
    ours = decode_block(words)
    bits = {word & 0x6F: canopen_state(word & 0x6F) for word in range(1 << 7)}
    np.testing.assert_array_equal(ours, [bits[int(word) & 0x6F] for word in words])


@given(st.lists(st.integers(0, 0xFFFF), min_size=1, max_size=50))
def test_one_and_many_decode_alike(words: list[int]) -> None:
    np.testing.assert_array_equal(decode_block(words), [decode(word) for word in words])


def test_every_commanded_transition_of_canopen_is_in_the_table_with_its_control_word() -> None:
    names = {name: state for state, name in CANOPEN.items()} | {"START": State.UNKNOWN}
    for (source, target), controlword in State402.TRANSITIONTABLE.items():
        edge = transition(names[source], names[target])
        assert edge is not None, (source, target)
        if controlword:
            assert controlword in {command.controlword for command in edge.commands}, edge
        elif edge.number in (0, 1, 14):
            assert edge.commands == ()


def test_the_standard_numbers_stand_once_each() -> None:
    assert [edge.number for edge in TRANSITIONS] == list(range(17))
    pairs = [(edge.source, edge.target) for edge in TRANSITIONS]
    assert len(set(pairs)) == len(pairs)
    # 13 leads from any state into the fault reaction; canopen's table leaves it out.
    assert transition(State.READY_TO_SWITCH_ON, State.FAULT_REACTION_ACTIVE) == TRANSITIONS[13]
    assert transition(State.FAULT, State.OPERATION_ENABLED) is None


def test_no_control_word_is_two_commands() -> None:
    for one, other in itertools.permutations(Command, 2):
        mask, value = other.value
        matches = one.controlword & mask == value
        assert not matches, (one, other)


def test_modes_are_those_of_canopen() -> None:
    for mode in Mode:
        name = OperationMode.CODE2NAME[mode.value].lower().replace("profiled", "profile")
        assert mode.text == name.replace("no mode", "none")
        supported = OperationMode.SUPPORTED[OperationMode.CODE2NAME[mode.value]]
        assert mode.support_bit == supported
