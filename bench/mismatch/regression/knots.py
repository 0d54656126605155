"""Where a table of a function has its knots: by the values of its quantity that the recordings hold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.simulation.frame import FloatArray

KNOTS = (6, 12)
"""knots of free functions of one quantity: coarse and fine"""
CLOSE_KNOTS = 28
"""knots of a function of the speed in even ratios: from 0.01 to 1 rad/s one a fifth further than the last"""
LEAST_VARIATION = 1e-9
"""relative spread of a quantity below which it is constant"""


def is_constant(values: FloatArray) -> bool:
    """Whether a quantity does not vary: nothing can be said to depend on it."""
    return values.size == 0 or float(np.ptp(values)) <= LEAST_VARIATION * (1.0 + float(np.abs(values).max()))


def ends(values: FloatArray) -> tuple[float, float] | None:
    """The least and the largest value: a table of two knots is a straight line. None for a constant."""
    if values.size == 0 or not np.isfinite(values).all():
        return None
    low, high = float(values.min()), float(values.max())
    return (low, high) if high - low > 1e-9 * (abs(low) + abs(high)) else None


def knots_of(values: FloatArray, number: int) -> tuple[float, ...] | None:
    """Knots half by the quantiles of the values and half evenly, apart by a part of the range; None if constant."""
    if is_constant(values):
        return None
    spread = float(np.ptp(values))
    levels = np.unique(np.round(values / spread, 4)) * spread
    if levels.size < 3:
        return None
    apart = spread / (3.0 * number)
    alike = np.split(levels, np.flatnonzero(np.diff(levels) > apart) + 1)
    if len(alike) <= number and all(np.ptp(group) < apart for group in alike):
        # a few levels, each with what a controller leaves: a knot each
        return tuple(float(group.mean()) for group in alike) if len(alike) >= 3 else None
    sample = np.quantile(values, np.linspace(0.005, 0.995, number))
    even = np.linspace(sample[0], sample[-1], number)
    kept: list[float] = []
    for knot in np.unique(0.5 * sample + 0.5 * even):
        if not kept or knot - kept[-1] >= apart:
            kept.append(float(knot))
    kept = _among_rows(kept, levels)
    return tuple(kept) if len(kept) >= 3 else None


def halved(knots: Sequence[float], values: FloatArray) -> tuple[float, ...]:
    """Knots with one more in the middle of each interval, where ``values`` (n,) lie near it."""
    known = np.asarray(knots)
    both = np.sort(np.concatenate([known, 0.5 * (known[1:] + known[:-1])]))
    kept = {*known.tolist(), *_among_rows(both.tolist(), np.sort(values))}
    return tuple(sorted(kept))


def _among_rows(knots: Sequence[float], values: FloatArray) -> list[float]:
    """Knots (increasing) with sorted ``values`` nearer to them than to the next ones, and both ends.

    In a gap a table's value stands on rows far away, and what it says there is made many times as large.
    """
    middles = 0.5 * (np.array(knots[1:]) + np.array(knots[:-1]))
    here = np.diff(np.searchsorted(values, middles))
    return [*knots[:1], *(k for k, n in zip(knots[1:-1], here, strict=True) if n), *knots[1:][-1:]]


def close_knots(speed: FloatArray) -> tuple[float, ...] | None:
    """Knots of a function of the speed in even ratios, for what happens about one speed; None where too few speeds were
    driven.

    A warm-up runs five times as fast as any point: knots at even distances leave no more than three to all the others.
    """
    driven = speed[speed > 0.0]
    if driven.size < CLOSE_KNOTS:
        return None
    low, high = np.quantile(driven, [0.02, 1.0])
    # nothing is known of a speed that was never driven
    edges = _among_rows([float(edge) for edge in np.log(np.geomspace(low, high, CLOSE_KNOTS))], np.sort(np.log(driven)))
    return tuple(float(edge) for edge in np.exp(edges)) if len(edges) > KNOTS[1] else None
