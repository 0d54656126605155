"""The compiled loop of the safety step: cycle after cycle into the memory, and past the rules, until one is broken."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import literal_unroll, njit
from numpy.typing import NDArray

from bench.safety._observe import Signal, count_losses, observe
from bench.safety.rules import CAUSE, REPORTED, SLOT, WHEN, When

FloatArray = NDArray[np.float64]


@njit(cache=True)
def first_broken(memory: FloatArray, rules: NDArray[np.int64], bounds: FloatArray, lost: bool, operating: bool) -> int:
    """Return the first rule that a memory breaks, −1 for none; a number that is none breaks no bound."""
    for k in range(rules.shape[0]):
        value = memory[rules[k, SLOT]]
        if value < bounds[0, k] or value > bounds[1, k]:
            when = rules[k, WHEN]
            if when == When.EVERY_CYCLE or (not lost and (operating or when != When.OPERATING)):
                return k
    return -1


@njit(cache=True)
def gather(arrays: tuple[NDArray[Any], ...], start: int, signals: FloatArray) -> None:
    """Fill the signals (20, n) from arrays of any type, from ``start`` on."""
    row = 0
    for array in literal_unroll(arrays):
        for i in range(signals.shape[1]):
            signals[row, i] = array[start + i]
        row += 1  # noqa: SIM113


@njit(cache=True)
def scan(
    memory: FloatArray,
    signals: FloatArray,
    operating: bool,
    ratio: float,
    cycle_time: float,
    standstill: float,
    follow: FloatArray,
    rules: NDArray[np.int64],
    bounds: FloatArray,
) -> tuple[int, int, float]:
    """Return (cycle, cause, value) of the first bad cycle, or (−1, 0, 0.0); updates ``memory`` in place."""
    for i in range(signals.shape[1]):
        lost = signals[Signal.GOOD, i] == 0.0
        count_losses(memory, lost, follow)
        if not lost:
            observe(memory, signals, i, operating, ratio, cycle_time, standstill, follow)
        broken = first_broken(memory, rules, bounds, lost, operating)
        if broken >= 0:
            return i, rules[broken, CAUSE], memory[rules[broken, REPORTED]]
    return -1, 0, 0.0
