"""A course over the campaign's time with knots where it bends: a level that comes and goes gradually.

A table with knots at even distances misses what changes within a minute of a campaign of hours, and levels that jump
(:mod:`bench.mismatch.regression.spells`) miss what takes its time. Here knots are put one after another where they
gain most, near the moments at which levels would jump (Friedman, Ann. Stat. 19 (1991) 1, for linear splines).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.regressors import Free, Regressor
from bench.simulation.frame import FloatArray, IntArray
from bench.simulation.quantities import in_words as factor_in_words
from bench.simulation.tables import Grid, hats

LOOKS = 2000
"""moments at which a course is asked where it is"""
AROUND = (0, 1, 2, 4, 8)
"""blocks from a jump at which a knot is tried: what changes gradually bends before its middle and after it"""


class Bends(Grid):
    """A table over time with knots where the course bends."""

    __slots__ = ()

    @property
    def changes(self) -> int:
        """How often it bends."""
        return len(self.knots[0]) - 2

    @property
    def course(self) -> str:
        """How often it bends."""
        return f"a course{times_of(self)} over time that bends {often(self.changes)}"

    def away(self, values: FloatArray) -> tuple[float, float] | None:
        """From when to when, s of the campaign, a course with ``values`` at its knots is half as far as ever from the
        straight line through its begin and its end; None where these are as far apart as that: it stays away.
        """
        knots = np.asarray(self.knots[0])
        time = np.linspace(knots[0], knots[-1], LOOKS)
        course = np.interp(time, knots, values)
        off = np.abs(course - np.interp(time, knots[[0, -1]], values[[0, -1]]))
        if abs(float(values[-1] - values[0])) > criteria.EITHER * float(off.max()):
            return None
        far = time[off > criteria.EITHER * float(off.max())]
        return (float(far[0]), float(far[-1])) if far.size else None


def times_of(grid: Grid) -> str:
    """What a table is multiplied with, in words; empty for nothing."""
    words = factor_in_words(grid.times)
    return f" times {words}" if words else ""


def often(number: int) -> str:
    """How often something happens, in words."""
    return "once" if number == 1 else f"{number} times"


def bends_of(regressor: Regressor) -> Bends | None:
    """The course with bends that a regressor is, if it is one."""
    grid = regressor.grids[0] if isinstance(regressor, Free) else None
    return grid if isinstance(grid, Bends) else None


def bending(
    time: FloatArray, value: FloatArray, weight: FloatArray, jumps: IntArray, most: int
) -> Iterator[tuple[tuple[float, ...], float]]:
    """Knots of courses through the ``value`` (b,) of blocks at a ``time`` (b,), increasing, each course with a bend
    more than the one before, up to ``most``, and the squares with a ``weight`` (b,) that it leaves. ``jumps``: blocks
    near which knots are tried.
    """
    tried = {int(k) + side * by for k in jumps for by in AROUND for side in (-1, 1)}
    possible = [k for k in sorted(tried) if 0 < k < time.size - 1 and weight[k] > 0.0]
    root = np.sqrt(weight)
    chosen: list[int] = []
    while len(chosen) < most:
        left = {k: _left(time, value, root, [*chosen, k]) for k in possible if k not in chosen}
        if not left:
            break
        chosen.append(min(left, key=lambda k: left[k]))
        chosen = _moved(time, value, root, chosen, possible)
        yield _knots(time, chosen), _left(time, value, root, chosen)


def _knots(time: FloatArray, chosen: Sequence[int]) -> tuple[float, ...]:
    return (float(time[0]), *sorted(float(time[k]) for k in chosen), float(time[-1]))


def _left(time: FloatArray, value: FloatArray, root: FloatArray, chosen: Sequence[int]) -> float:
    """Weighted squares that the best course with bends at ``chosen`` blocks leaves."""
    basis = hats(time, np.asarray(_knots(time, chosen))) * root[:, None]
    target = value * root
    normal = basis.T @ basis
    normal += 1e-9 * np.trace(normal) / len(normal) * np.eye(len(normal))
    by = basis.T @ target
    return float(target @ target - by @ np.linalg.solve(normal, by))


def _moved(
    time: FloatArray, value: FloatArray, root: FloatArray, chosen: Sequence[int], possible: Sequence[int]
) -> list[int]:
    """The bends with each in turn where it leaves least, the others as they are."""
    now = list(chosen)
    for i in range(len(now)):
        others = now[:i] + now[i + 1 :]
        free = [k for k in possible if k not in others]
        now[i] = min(free, key=lambda k: _left(time, value, root, [*others, k]))
    return now
