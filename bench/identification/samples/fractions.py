"""Orders that are no whole number, such as those of a shaft that turns 7.297 times per revolution of the output.

A transform of whole orders has no place for them: the few sums that a fit with them needs are made one by one, at the
sums and differences with every whole order, and stand behind the whole orders' in one array.
"""

from __future__ import annotations

from collections.abc import Sequence

import finufft
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
ComplexArray = NDArray[np.complex128]

NEAR = 1e-9
"""Orders closer than this are one."""
TOLERANCE = 1e-10
NO_FRACTIONS: FloatArray = np.empty(0)
NO_FRACTIONS.setflags(write=False)


def is_whole(orders: FloatArray) -> NDArray[np.bool_]:
    """Which orders (K,) are whole numbers."""
    return np.asarray(np.abs(orders - np.rint(orders)) < NEAR)


def fractions(orders: Sequence[float]) -> FloatArray:
    """Orders (F,) that are no whole number, ascending."""
    values = np.unique(np.asarray(orders, dtype=np.float64))
    return values[~is_whole(values)]


def extra_frequencies(found: FloatArray, highest_order: int) -> FloatArray:
    """Frequencies (E,) of the unit sums that fractions (F,) need with those to ``highest_order`` and each other."""
    if not found.size:
        return NO_FRACTIONS
    other = np.concatenate([np.arange(highest_order + 1.0), found])
    both = np.abs(np.concatenate([np.add.outer(found, other).ravel(), np.subtract.outer(found, other).ravel()]))
    both = both[~is_whole(both)]
    ordered = np.sort(both)
    return ordered[np.diff(ordered, prepend=-1.0) > NEAR]


def sums_at(theta: FloatArray, strengths: FloatArray, frequencies: FloatArray) -> ComplexArray:
    """Σ_j strengths_j·exp(i·f·θ_j) (E,) at any frequencies (E,), by one transform of type 3."""
    if not frequencies.size:
        return np.empty(0, dtype=np.complex128)
    c = strengths.astype(np.complex128)
    found = finufft.nufft1d3(theta, c, np.ascontiguousarray(frequencies), eps=TOLERANCE, isign=1, nthreads=1)
    return np.asarray(found, dtype=np.complex128)


def columns(frequencies: FloatArray, whole: int, extra: FloatArray) -> IntArray:
    """Columns of frequencies (...,) ≥ 0 in an array of ``whole`` whole orders with ``extra`` (E,) behind them.

    Raises IndexError for one that has no column.
    """
    frequencies = np.asarray(frequencies, dtype=np.float64)
    nearest = np.rint(frequencies)
    behind = np.abs(frequencies - nearest) >= NEAR
    out = nearest.astype(np.int64)
    if behind.any():
        position = np.searchsorted(extra, frequencies[behind] - NEAR)
        if position.max(initial=0) >= extra.size or (np.abs(extra[position] - frequencies[behind]) >= NEAR).any():
            raise IndexError("a sum was asked for at an order that was not looked at")
        out[behind] = whole + position
    if out[~behind].max(initial=0) >= whole:
        raise IndexError("a sum was asked for beyond the highest order")
    return out
