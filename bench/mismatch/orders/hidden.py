"""An order between two whole ones that these hide: it leaks into both of them, and once they are fitted in each
revolution nothing of it is left.

A wave of such an order makes vectors of both whole ones in a proportion that the angle of each revolution tells. So
the two are one order where one alone says what they say: with whole orders alone they would be two, or one whose phase
runs away with the angle. It is asked when all whole orders that stand out are fitted: what of others still leaks into
the two would be taken for it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.orders.between import is_between, left_of, plainly
from bench.mismatch.orders.joint import Evidence
from bench.mismatch.orders.look import PARTS
from bench.mismatch.orders.revolutions import HIGHEST_BETWEEN, Complex, Seen
from bench.mismatch.orders.varying import varying_gain
from bench.mismatch.orders.weak import NEIGHBOUR_REVOLUTIONS, Stage, WeakOrder
from bench.simulation.frame import FloatArray

HIDDEN = 0.3
"""share of a wave's energy that fitted whole orders at its sides take at least where they hide it: over one revolution
each of the two takes 0.405 of a wave half way between them, over one and a tenth 0.33
"""

NEAR = 3.0
"""orders on either side that take part of a wave beside the two: a fifth of it at most over one revolution"""
RIDGE = 1e-6
"""keeps orders that one revolution does not tell apart from breaking a solve"""


def unhide(seen: Seen, known: Collection[float], found: dict[float, WeakOrder], by: Evidence) -> bool:
    """Put an order between two whole ones in the place of these, among the ``found`` orders beside the ``known`` ones,
    where it says more of both, or of the one that the simulation does not have. Whether one was put so.
    """
    whole = Stage.of(seen, by.revolutions, by.train)
    if whole is None:
        return False
    pairs = _Pairs.of(whole, seen, by, known, found)
    lower = sorted({k for f in found if not is_between(f) for k in (f - 1.0, f)})
    best = [line for line in (pairs.best(k) for k in lower) if line is not None]
    gone: set[float] = set()
    for _, line, sides in sorted(best, key=lambda item: -item[0]):
        if gone.isdisjoint(sides):
            gone |= {*sides}
            for side in sides:
                found.pop(side, None)
            found[line.order] = line
    return bool(gone)


@dataclass(frozen=True, slots=True)
class _Pairs:
    """Found whole orders and their neighbours in the training revolutions.

    These ``begin`` (revolutions,) at an angle, ``span`` (revolutions,) others, of which ``turned`` (revolutions,) are
    whole revolutions, rad.
    """

    whole: Stage
    seen: Seen
    by: Evidence
    known: Collection[float]
    found: Mapping[float, WeakOrder]
    begin: FloatArray
    span: FloatArray
    turned: FloatArray

    @classmethod
    def of(
        cls, whole: Stage, seen: Seen, by: Evidence, known: Collection[float], found: Mapping[float, WeakOrder]
    ) -> _Pairs:
        """The pairs, and how far the training revolutions turned."""
        theta = [rest.theta for rest, trained in zip(seen.rest, by.train, strict=True) if trained]
        begin, span = np.array([t[0] for t in theta]), np.array([t[-1] - t[0] for t in theta])
        revolutions = np.array([t.revolutions for t in whole.revolutions])
        return cls(whole, seen, by, known, found, begin, span, np.sign(span) * 2.0 * np.pi * revolutions)

    def best(self, lower: float) -> tuple[float, WeakOrder, tuple[float, ...]] | None:
        """The order between ``lower`` and the next whole one that gains most in their place: what it gains more, the
        order, the whole ones; None where none gains enough.
        """
        near = [f for f in self.seen.orders if is_between(f) and lower < f < lower + 1.0]
        # of one that the simulation has nobody knows what it would be alone: the other one is asked
        sides = tuple(f for f in (lower, lower + 1.0) if f not in self.known)
        if lower < 1.0 or lower + 1.0 > HIGHEST_BETWEEN or near or not sides:
            return None
        here = [self._side(f) for f in sides]
        units = [float(one.shape[0] / here[0].shape[0]) for one in here]
        before = sum(_score(here[0], _energy(one) / unit**2) for one, unit in zip(here, units, strict=True))
        least = sum(self._whole_gain(f, one, False) for f, one in zip(sides, here, strict=True)) + self._price
        best: tuple[float, WeakOrder] | None = None
        for part in range(1, PARTS):
            order = lower + part / PARTS
            together = self._together(order, sides, here)
            if together is None:
                continue
            one, across = together
            most = before - _score(one, 0.0) - across  # all of it said
            if most <= max(least, best[0] if best is not None else -np.inf):
                continue
            line = plainly(one, order)
            if line.gain <= self.by.price + float(np.log(PARTS)):
                continue  # it would go again as needless (joint.py)
            gain = max(line.gain, varying_gain(one))
            total = before - _score(one, _energy(one)) + gain - across
            if total > max(least, best[0] if best is not None else -np.inf):
                best = total, line
        if best is None:
            return None
        if len(sides) == 1 and best[0] - self._elsewhere(sides[0], lower, here[0]) < criteria.RICHER:
            return None
        more = best[0] - sum(self._whole_gain(f, one, True) for f, one in zip(sides, here, strict=True)) - self._price
        return (more, best[1], sides) if more > 0.0 else None

    def _elsewhere(self, side: float, lower: float, here: Stage) -> float:
        """The most that an order on the other side of a whole one gains from it alone: revolutions that all begin at
        one angle do not tell on which side it is.
        """
        other = side - 1.0 if side == lower else side
        gains = [0.0]
        for part in range(1, PARTS):
            order = other + part / PARTS
            if min(abs(order - f) for f in self.seen.orders) < 0.5 / PARTS:
                continue  # it is fitted: nothing of it is in the others
            one = self._along(order, self._taken(order), (side,), [here])[0]
            gains.append(max(plainly(one, order).gain, varying_gain(one)))
        return max(gains)

    @property
    def _price(self) -> float:
        """An order between two has to gain as much as one of many forms and places."""
        return self.by.price + criteria.RICHER + float(np.log(PARTS))

    def _whole_gain(self, order: float, one: Stage, varying: bool) -> float:
        """What a whole order says of its vectors, less what an order has to gain; nothing of one that was not found, or
        gains less.
        """
        if order not in self.found:
            return 0.0
        gain = float(one.gains(one.vectors)[0][0])
        return max((max(gain, varying_gain(one)) if varying else gain) - self.by.price, 0.0)

    def _side(self, order: float) -> Stage:
        """The revolutions at one whole order."""
        whole = self.whole
        if order not in self.seen.orders:
            vectors = whole.vectors[:, round(order)][:, None]
            return whole.rescaled(vectors, whole.scale, np.array([whole.shape_at(order)]))
        scale = whole.scale / left_of(whole, order, self.seen.orders)
        vectors = (self.seen.vectors[self.by.train, self.seen.orders.index(order)] / scale)[:, None]
        return whole.rescaled(vectors, scale, np.array([whole.shape_at(order)]))

    def _together(self, order: float, sides: tuple[float, ...], here: list[Stage]) -> tuple[Stage, float] | None:
        """The revolutions at an order between, from the vectors that its wave makes of the whole ones at its sides; and
        the score of what these have that it does not make: nothing of one alone. None where they take little of it: it
        is not hidden.
        """
        if not any(f in self.found for f in sides):
            return None
        taken = self._taken(order)
        beside = [f for f in (np.floor(order), np.floor(order) + 1.0) if f in taken]
        if float(sum(np.mean(np.abs(taken[f]) ** 2) for f in beside)) < HIDDEN:
            return None
        one, shown = self._along(order, taken, sides, here)
        if len(sides) == 1:
            return one, 0.0
        across = max(float(np.sum(np.abs(shown) ** 2)) - _energy(one), 0.0)
        return one, _score(one, across)

    def _along(
        self, order: float, taken: Mapping[float, Complex], sides: tuple[float, ...], here: list[Stage]
    ) -> tuple[Stage, Complex]:
        """What the vectors of whole orders have of a wave of an ``order``, of which fitted orders have ``taken`` some,
        as the revolutions at it; and these vectors (revolutions, sides), each over its own noise, in units of the first
        one's shape.
        """
        units = np.column_stack([one.scale * one.shape[0] for one in here]) / here[0].shape[0]
        makes = np.column_stack([self._makes(order, taken, f) for f in sides]) / units
        shown = np.column_stack([one.vectors[:, 0] * one.scale for one in here]) / units
        size = np.sqrt(np.sum(np.abs(makes) ** 2, axis=1))
        along = np.sum(np.conj(makes) * shown, axis=1) / size
        return here[0].rescaled(along[:, None], 1.0 / size, here[0].shape), shown

    def _taken(self, order: float) -> dict[float, Complex]:
        """Vectors (revolutions,) that a wave of an ``order`` with the vector 1 makes of each order near it that is
        fitted in each revolution.
        """
        near = [f for f in self.seen.orders if abs(f - order) <= NEAR]
        if not near:
            return {}
        mixed = np.stack([[self._mean(g - f) for g in near] for f in near]).transpose(2, 0, 1)
        alone = np.stack([self._mean(order - f) for f in near], axis=1)
        taken = np.linalg.solve(mixed + RIDGE * np.eye(len(near)), alone[:, :, None])[:, :, 0]
        return dict(zip(near, taken.T, strict=True))

    def _makes(self, order: float, taken: Mapping[float, Complex], side: float) -> Complex:
        """Vectors (revolutions,) that such a wave makes of one whole order, of which fitted orders have ``taken``
        some.
        """
        if side in taken:
            return taken[side]
        left = self._mean(order - side, whole_revolutions=True)
        for f, vectors in taken.items():
            left -= vectors * self._mean(f - side, whole_revolutions=True)
        return left

    def _mean(self, off: float, whole_revolutions: bool = False) -> Complex:
        """Mean (revolutions,) of exp(j*off*theta) over the revolutions' rows, or those of whole revolutions."""
        span = self.turned if whole_revolutions else self.span
        return np.asarray(np.sinc(off * span / (2.0 * np.pi)) * np.exp(1j * off * (self.begin + 0.5 * span)))


def _score(one: Stage, energy: float) -> float:
    """Log-likelihood that an energy of a stage costs (:func:`bench.mismatch.orders.weak.gain_of`)."""
    prior = 2.0 * NEIGHBOUR_REVOLUTIONS * float(one.shape[0]) ** 2
    return (len(one.revolutions) + NEIGHBOUR_REVOLUTIONS) * float(np.log(energy + prior))


def _energy(one: Stage) -> float:
    return float(np.sum(np.abs(one.vectors) ** 2))
