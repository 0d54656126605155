"""Orders that stand between the whole ones: of a wheel or a belt that does not turn so often as the output, nor a whole
number of times.

They are looked for at parts of an order. Where the revolutions follow each other through many turns of the output,
that grid is too coarse: the phase of a wheel of 26 teeth on one of 87, taken for 10/3 turns, runs off by a third of a
turn in 26. Then the grid is shifted in steps, and what stands is followed to where it gains most.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from bench.mismatch import criteria
from bench.mismatch.orders.look import PARTS
from bench.mismatch.orders.turns import HIGHEST_BETWEEN, Seen, Turn
from bench.mismatch.orders.weak import LEAK, MODELS, Stage, WeakOrder
from bench.simulation.frame import FloatArray

SHIFTS = 8
"""to either side of a part of an order at most: enough for 48 revolutions, and of more the search would take long"""
STEPS = 4.0
"""shifts while the phase of an order runs off by a turn between the first revolution and the last"""


def search_between(
    seen: Seen,
    turns: Sequence[Turn],
    train: NDArray[np.bool_],
    fitted: Sequence[float],
    floor: float,
    price: float,
    shifted: bool,
) -> list[WeakOrder]:
    """Orders between the whole ones that stand in the training revolutions beside those that are ``fitted``; of those
    that leak into each other the strongest. ``floor`` and ``price`` as in :func:`bench.mismatch.orders.weak.search`;
    ``shifted``: whether the grid is shifted as well, which takes long, and finds orders in a tone where it is heard at
    few speeds.
    """
    whole = Stage.of(seen, turns, train)
    if whole is None:
        return []
    shifts = shifts_of(seen, train) if shifted else np.zeros(1)
    # a wave of less than a period in a revolution's segment is a part of its line
    lowest = 1.0 / min(t.revolutions for t in whole.turns)
    grid = np.arange(HIGHEST_BETWEEN * PARTS + 1) / PARTS
    shape = whole.shape[np.round(grid).astype(np.int64)]
    best, at, which = np.full(grid.size, -np.inf), np.zeros(grid.size), np.zeros(grid.size, dtype=np.int64)
    for shift in shifts:
        usable = (grid + shift > lowest) & ((np.round(grid) != grid) | (shift != 0.0))
        for f in fitted:
            usable &= np.abs(grid + shift - f) > 0.5 / PARTS
        stage = replace(whole, vectors=seen.between(shift)[train] / whole.scale[:, None], shape=shape)
        gain, number = stage.gains(stage.vectors)
        # an order that is no part of a whole one asks for more
        gain = np.where(usable, gain - (criteria.RICHER if shift else 0.0), -np.inf)
        better = gain > best
        best[better], at[better], which[better] = gain[better], shift, number[better]
    out: list[WeakOrder] = []
    # as many times more are looked at than there are whole orders
    while best.max() > price + np.log(PARTS * shifts.size):
        k = int(np.argmax(best))
        order = float(grid[k] + at[k])
        if at[k]:
            order = followed(seen, train, whole, order, float(shifts[1]), float(shape[k]))
        vectors = _vectors(seen, train, whole, order)
        line = whole.estimated(order, MODELS[which[k]], vectors, float(shape[k]), float(best[k]))
        best[np.abs(grid - order) < LEAK] = -np.inf
        if whole.power(line) > criteria.LEAST_POWER * floor**2 * whole.share(line.order, fitted) ** 2:
            out.append(line)
    return out


def shifts_of(seen: Seen, train: NDArray[np.bool_]) -> FloatArray:
    """Shifts (k,) of the grid, 0 first: as many as the way from the first training revolution to the last asks for."""
    theta = [rest.theta for rest, own in zip(seen.rest, train, strict=True) if own]
    span = (max(float(t.max()) for t in theta) - min(float(t.min()) for t in theta)) / (2.0 * np.pi)
    number = min(int(STEPS * span / (2 * PARTS)), SHIFTS)
    steps = np.arange(1, number + 1) / (PARTS * (2 * number + 1))
    return np.concatenate([[0.0], steps, -steps])


def followed(seen: Seen, train: NDArray[np.bool_], whole: Stage, order: float, step: float, sigma: float) -> float:
    """Where within a ``step`` of an order it gains most."""

    def loss(f: float) -> float:
        vectors = _vectors(seen, train, whole, f)[:, None]
        return -float(replace(whole, vectors=vectors, shape=np.array([sigma])).gains(vectors)[0][0])

    found = minimize_scalar(loss, bounds=(order - step, order + step), method="bounded", options={"xatol": 0.01 * step})
    return float(f"{found.x:.6g}")


def _vectors(seen: Seen, train: NDArray[np.bool_], whole: Stage, order: float) -> NDArray[np.complex128]:
    """Vectors of the residual of the training revolutions at an order, over their scale (turns,)."""
    values = [rest.at(order) for rest, own in zip(seen.rest, train, strict=True) if own]
    return np.asarray(np.array(values) / whole.scale)
