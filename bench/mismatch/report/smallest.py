"""The smallest interval that holds a share of some energy."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations

import numpy as np

from bench.simulation.frame import FloatArray

ROUNDING = 1e-9
"""relative: energies that differ by less are the same"""
CUTS = {1: 1, 2: 10, 3: 4}
"""ways to divide what a box may leave out between one quantity and the others, by the number of quantities"""
NARROW = 0.01
"""of the range of a quantity: narrower intervals are not worth that another quantity's gets wider"""


def interval(values: FloatArray, energy: FloatArray, least: float) -> tuple[float, float] | None:
    """The shortest interval whose rows hold ``least`` of energy; None where there is not so much.

    ``values`` (n,) and ``energy`` (n,) of the rows. Its ends are values of rows.
    """
    acting = energy > 0
    if not acting.any():
        return None
    levels, number = np.unique(values[acting], return_inverse=True)
    held = np.bincount(number, energy[acting])
    total = np.concatenate(([0.0], np.cumsum(held)))
    if total[-1] < least * (1.0 - ROUNDING):
        return None
    # the first end at which enough is held, for each begin
    last = np.searchsorted(total, (total[:-1] + least) * (1.0 - ROUNDING))
    possible = np.flatnonzero(last <= levels.size)
    width = levels[np.maximum(last[possible], 1) - 1] - levels[possible]
    begin = possible[int(np.argmin(width))]
    return float(levels[begin]), float(levels[max(int(last[begin]) - 1, begin)])


def box(values: Mapping[str, FloatArray], energy: FloatArray, share: float) -> dict[str, tuple[float, float]]:
    """The smallest intervals of several quantities, of those tried, that together hold a ``share`` of some energy.

    ``values`` (n,) of each quantity and ``energy`` (n,) of the rows. The smallest have the least product of widths,
    each relative to all that the rows with energy have. Empty where there is no energy.
    """
    acting = energy > 0
    if not acting.any():
        return {}
    inside = {name: each[acting] for name, each in values.items()}
    held, total = energy[acting], float(energy[acting].sum())
    cuts = CUTS[len(values)] if values else 1
    boxes = [found for order in permutations(inside) for found in _boxes(inside, order, held, (total, share), cuts)]
    return min(boxes, key=lambda found: _size(found, inside))


def _boxes(
    values: Mapping[str, FloatArray],
    order: tuple[str, ...],
    energy: FloatArray,
    wanted: tuple[float, float],
    cuts: int,
) -> list[dict[str, tuple[float, float]]]:
    """Boxes that hold a share of a total (``wanted``: total, share): the first quantity of an ``order`` leaves out one
    of so many ``cuts`` of what may be left out, the others the rest.
    """
    total, share = wanted
    if not order:
        return [{}]
    name, *others = order
    # the last takes all that is left to leave out
    levels = np.linspace(share, 1.0, cuts + 1) if others else [share]
    out = []
    for level in levels:
        found = interval(values[name], energy, float(level) * total)
        if found is None:
            continue
        within = np.where((values[name] >= found[0]) & (values[name] <= found[1]), energy, 0.0)
        out += [{name: found} | rest for rest in _boxes(values, tuple(others), within, wanted, cuts)]
    return out


def _size(found: Mapping[str, tuple[float, float]], values: Mapping[str, FloatArray]) -> float:
    """Product of the widths of a box, each relative to the range of its quantity."""
    spans = {name: max(float(np.ptp(values[name])), 1e-300) for name in found}
    return float(np.prod([max((high - low) / spans[name], NARROW) for name, (low, high) in found.items()]))


def steps(
    values: FloatArray, added: FloatArray, weight: FloatArray, parts: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Where a function changes: ends (k,), (k,) of its pieces, and the energy (k,) of its slope in each.

    The mean of ``added`` in each of ``parts`` equal parts of the range of ``values``, weighted, joined by lines; the
    energy of a line is its slope, less the median slope (what a straight line can say), squared, times its length.
    """
    acting = weight > 0
    low, high = float(values[acting].min()), float(values[acting].max())
    if high <= low:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    number = np.minimum(((values[acting] - low) / (high - low) * parts).astype(int), parts - 1)
    count = np.bincount(number, weight[acting], parts)
    full = np.flatnonzero(count > 0)
    if full.size < 2:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    centre = np.bincount(number, values[acting] * weight[acting], parts)[full] / count[full]
    mean = np.bincount(number, added[acting] * weight[acting], parts)[full] / count[full]
    length = np.diff(centre)
    slope = np.diff(mean) / length
    order = np.argsort(slope)
    usual = slope[order[int(np.searchsorted(np.cumsum(length[order]), 0.5 * length.sum()))]]
    return centre[:-1], centre[1:], np.asarray((slope - usual) ** 2 * length)


def pieces(begins: FloatArray, ends: FloatArray, energy: FloatArray, share: float) -> tuple[float, float] | None:
    """The shortest run of neighbouring pieces that holds a ``share`` of their energy."""
    if energy.size == 0 or energy.sum() <= 0.0:
        return None
    total = np.concatenate(([0.0], np.cumsum(energy)))
    least = share * float(energy.sum()) * (1.0 - ROUNDING)
    last = np.searchsorted(total, total[:-1] + least)
    possible = np.flatnonzero(last <= energy.size)
    width = ends[np.maximum(last[possible], 1) - 1] - begins[possible]
    begin = possible[int(np.argmin(width))]
    return float(begins[begin]), float(ends[int(last[begin]) - 1])
