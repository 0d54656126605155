"""Found orders once all of them are fitted together: each where it gains most beside the others, or gone where it gains
next to nothing.

An order was found when others were still missing, and their leakage was part of what it was found in.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.orders.between import EXACT, FARTHEST, NEXT, SIDE_LINES, Path, is_between, left_of, rounded
from bench.mismatch.orders.look import PARTS
from bench.mismatch.orders.revolutions import Complex, Revolution, Seen
from bench.mismatch.orders.weak import Stage, WeakOrder

SETTLINGS = 3
"""times that found orders are moved and asked again"""
BESIDE_WHOLE = 2.0 * NEXT
"""by how much an order that was found as a whole one may be off: farther from it, it is found for itself, and a whole
one would only go to a place where the phases are nearly alike
"""
APART = 1.0
"""orders between two that go at once: of two that say the same one may be needed"""


Answer = Callable[[float], "Complex | complex"]
"""what multiplies an order's vectors: in each training revolution (revolutions,), or the same in all"""


def no_answer(_order: float) -> complex:
    """Orders that have passed nothing."""
    return 1.0 + 0.0j


@dataclass(frozen=True, slots=True)
class Evidence:
    """What found orders are judged by: ``revolutions``, which of them may be fitted (``train``), the ``price`` that an
    order has to gain, and what the orders have passed (``answer``).
    """

    revolutions: Sequence[Revolution]
    train: NDArray[np.bool_]
    price: float
    answer: Answer = no_answer


def settled(look: Callable[[Collection[float]], Seen], now: Seen, found: dict[float, WeakOrder], by: Evidence) -> Seen:
    """What the revolutions show when each of the ``found`` orders, changed here, stands where it gains most beside all
    others and those that these make needless are gone. ``look`` at some found orders beside the known ones, ``now`` at
    those to begin with.
    """
    for _ in range(SETTLINGS):
        steps = moved(now, found, by)
        for old, new in steps.items():
            found[new] = replace(found.pop(old), order=new)
        if steps:
            now = look(found)
        gone = needless(now, found, by)
        for order in gone:
            del found[order]
        if gone:
            now = look(found)
        if not steps and not gone:
            break
    return now


def moved(seen: Seen, found: Mapping[float, WeakOrder], by: Evidence) -> dict[float, float]:
    """Found orders that gain clearly more a little beside where they stand: old and new order.

    Of an order that is a little off, the phase runs away with the angle, from one revolution to the next. That of a
    whole one does so where what stands there is no whole number: it was found as a whole one that changes with the
    state, or in some of the revolutions alone. Most orders are whole: it moves only where that gains as much more as an
    order of its own has to.
    """
    whole = Stage.of(seen, by.revolutions, by.train)
    if whole is None:
        return {}
    path = Path.of(seen, by.train, FARTHEST)
    out: dict[float, float] = {}
    gained: dict[float, float] = {}
    for order in found:
        one = _alone(whole, seen, order, by)
        here = float(path.gains(one, np.zeros(1))[0])
        # a found order may stand where this one should: then it goes. One that the simulation has stays
        more, gain = path.away_from(order, [f for f in seen.orders if f not in found]).followed(one)
        if not is_between(order):
            near = 0.0 < abs(more) <= BESIDE_WHOLE and gain > by.price + here
            if near and path.told(one, more) > by.price + path.told(one, 0.0):
                out[order], gained[order] = rounded(order + more), gain - here
            continue
        to_whole, to_part = round(order) - order, round(order * PARTS) / PARTS - order
        near = abs(to_whole) <= 1.0 / PARTS and round(order) not in seen.orders
        off = abs(to_part) > EXACT and all(abs(order + to_part - f) > EXACT for f in seen.orders)
        if not (near or off or more):
            continue
        told = path.told(one, more)
        # where it stands is one of many places too, unless that is a part of an order
        if abs(to_part) > EXACT and not more:
            told -= path.price
        # a whole number, and next to it a part of an order, is no choice of one of many
        if near and path.told(one, to_whole) + path.price >= told:
            out[order] = float(round(order))
        elif off and path.told(one, to_part) + path.price >= told:
            out[order] = round(order * PARTS) / PARTS
        elif more and told > path.told(one, 0.0):
            out[order] = rounded(order + more)
        gained[order] = gain - here
    return _apart(out, gained)


def _apart(steps: Mapping[float, float], gained: Mapping[float, float]) -> dict[float, float]:
    """Of orders that leak into each other, before a step or after it, the step that gains most: each was asked with the
    others where they stand, and several would meet at the best of all places.
    """
    out: dict[float, float] = {}
    for order in sorted(steps, key=lambda f: -gained[f]):
        ends = (order, steps[order])
        if all(abs(a - b) > SIDE_LINES for other in out for a in ends for b in (other, out[other])):
            out[order] = steps[order]
    return out


def needless(seen: Seen, found: Mapping[float, WeakOrder], by: Evidence) -> list[float]:
    """Found orders that gain less than noise might beside all others, the least of each neighbourhood."""
    whole = Stage.of(seen, by.revolutions, by.train)
    if whole is None:
        return []
    gains = {}
    for order in found:
        one = _alone(whole, seen, order, by)
        gains[order] = float(one.gains(one.vectors)[0][0])
    least = {f: by.price + (np.log(PARTS) if is_between(f) else 0.0) for f in gains}
    out: list[float] = []
    for order in sorted(gains, key=lambda f: gains[f]):
        if gains[order] < least[order] and all(abs(order - gone) > APART for gone in out):
            out.append(order)
    return out


def _alone(whole: Stage, seen: Seen, order: float, by: Evidence) -> Stage:
    """The training revolutions at one of the orders that were fitted together, before what it has passed; each as sure
    as the others leave it.
    """
    answer = by.answer(order)
    scale = whole.scale / left_of(whole, order, seen.orders) / np.abs(answer)
    residual: Complex = seen.vectors[by.train, seen.orders.index(order)] / answer
    return whole.rescaled((residual / scale)[:, None], scale, np.array([whole.shape_at(order)]))
