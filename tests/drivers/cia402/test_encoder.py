import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.cia402 import EncoderExtender


@st.composite
def journeys(draw: st.DrawFn) -> tuple[int, np.ndarray, list[int]]:
    """Modulus, true positions whose steps stay below half of it, and block lengths."""
    modulus = draw(st.sampled_from([1 << 32, 1 << 25, 8192, 1 << 16, 1000, 2]))
    half = (modulus - 1) // 2
    start = draw(st.integers(0, modulus - 1))
    steps = draw(st.lists(st.integers(-half, half), min_size=0, max_size=120))
    path = start + np.concatenate(([0], np.cumsum(np.array(steps, np.int64))))
    blocks = draw(st.lists(st.integers(1, 40), min_size=1, max_size=10))
    return modulus, path, blocks


@given(journeys())
def test_the_true_path_comes_back_whatever_the_blocks(journey: tuple[int, np.ndarray, list[int]]) -> None:
    modulus, path, blocks = journey
    extender = EncoderExtender(modulus)
    raw = path % modulus
    extended, at = [], 0
    while at < len(raw):
        length = blocks[at % len(blocks)]
        extended.append(extender.extend(raw[at : at + length]))
        at += length
    np.testing.assert_array_equal(np.concatenate(extended), path)
    assert extender.last == path[-1]


@given(st.integers(-(2**31), 2**31 - 1), st.lists(st.integers(-(2**30), 2**30), max_size=100))
def test_int32_of_the_drive_wraps_both_ways(start: int, steps: list[int]) -> None:
    path = np.cumsum(np.array([start, *steps], np.int64))
    raw = path.astype(np.int32)  # wraps as the drive's counter does
    np.testing.assert_array_equal(EncoderExtender().extend(raw), path)


def test_reset_forgets_or_keeps_on_from_a_known_place() -> None:
    extender = EncoderExtender(100)
    extender.extend(np.array([90, 95, 5]))
    assert extender.last == 105
    extender.reset()
    assert extender.extend(np.array([5]))[0] == 5
    extender.reset(position=1_000_042)
    np.testing.assert_array_equal(extender.extend(np.array([45, 60])), [1_000_045, 1_000_060])


def test_empty_blocks_change_nothing() -> None:
    extender = EncoderExtender()
    assert extender.extend(np.array([], np.int32)).size == 0
    assert extender.last is None


def test_a_counter_of_one_place_is_none() -> None:
    with pytest.raises(ValueError, match="wrap after 1 counts"):
        EncoderExtender(1)
