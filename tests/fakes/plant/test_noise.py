"""The compiled normal numbers and the friction table."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numba import njit
from numpy.typing import NDArray
from scipy import stats

from fakes.plant.drag_table import look_up, speeds, temperatures
from fakes.plant.noise import normal, seed_words


@njit(cache=True)
def _draw(words: NDArray[np.uint64], count: int) -> NDArray[np.float64]:
    out = np.empty(count)
    for i in range(count):
        out[i] = normal(words)
    return out


def test_normal_numbers_are_normal_into_the_tail() -> None:
    numbers = _draw(seed_words(7), 1_000_000)
    assert stats.kstest(numbers[:200_000], "norm").pvalue > 1e-3
    for edge in (1.0, 2.0, 3.0, 3.6, 4.2):
        expected = 1e6 * 2 * stats.norm.sf(edge)
        assert abs(np.count_nonzero(np.abs(numbers) > edge) - expected) < 5 * np.sqrt(expected)
    assert abs(np.corrcoef(numbers[1:], numbers[:-1])[0, 1]) < 5e-3


def test_seed_is_the_whole_state() -> None:
    words = seed_words(3)
    _draw(words, 1000)
    copy = words.copy()
    assert (_draw(words, 500) == _draw(copy, 500)).all()
    assert (seed_words(3) != seed_words(4)).any()


@given(st.floats(0.0, 700.0), st.floats(-20.0, 130.0))
def test_friction_table_interpolates(speed: float, temperature: float) -> None:
    w, t = np.meshgrid(speeds(), temperatures(), indexing="ij")
    table = 0.4 * np.exp(-((w / 8.0) ** 2)) + 1e-6 * w**2 + 1e-3 * t
    expected = 0.4 * np.exp(-((speed / 8.0) ** 2)) + 1e-6 * speed**2 + 1e-3 * temperature
    assert abs(look_up(table, speed, temperature) - expected) < 1e-3
