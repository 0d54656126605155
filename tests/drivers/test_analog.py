import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from drivers import analog
from drivers.runs import run_lengths


@given(st.lists(st.booleans(), min_size=1, max_size=80), st.lists(st.integers(1, 20), min_size=1, max_size=8))
def test_runs_are_those_of_a_plain_loop_whatever_the_blocks(condition: list[bool], blocks: list[int]) -> None:
    expected, run = [], 0
    for holds in condition:
        run = run + 1 if holds else 0
        expected.append(run)
    got: list[int] = []
    carry = turn = 0
    while len(got) < len(condition):
        block = np.array(condition[len(got) : len(got) + blocks[turn % len(blocks)]])
        lengths = run_lengths(block, carry)
        carry = int(lengths[-1])
        got += lengths.tolist()
        turn += 1
    assert got == expected


@given(st.lists(st.integers(1, 9), min_size=1, max_size=20), st.integers(1, 7))
def test_ages_count_cycles_since_the_toggle_changed(conversions: list[int], block: int) -> None:
    # Each conversion is held for so many cycles; the toggle bit flips with each.
    toggles = np.repeat(np.arange(len(conversions)) % 2, conversions).astype(np.uint16) * np.uint16(analog.TOGGLE)
    expected = np.concatenate([np.arange(held) for held in conversions])
    got: list[int] = []
    toggle, age = int(toggles[0]) ^ analog.TOGGLE, 0  # it changes with the very first sample
    for at in range(0, len(toggles), block):
        ages = analog.ages(toggles[at : at + block], toggle, age)
        toggle, age = int(toggles[min(at + block, len(toggles)) - 1]), int(ages[-1])
        got += ages.tolist()
    np.testing.assert_array_equal(got, expected)


def test_any_bad_bit_makes_a_reading_unusable() -> None:
    bad = [analog.UNDERRANGE, analog.OVERRANGE, analog.ERROR, analog.INVALID]
    status = np.array([0, analog.TOGGLE, 1 << 2, *bad, bad[0] | bad[2]], np.uint16)
    np.testing.assert_array_equal(analog.usable(status), [True] * 3 + [False] * 5)
