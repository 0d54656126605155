"""Orders that stand between the whole ones: of a cage, a wheel or a belt that turns no whole number of times with the
output.

Where they are is not known beforehand. The energy of the revolutions, whatever its phase, shows at parts of an order
where something stands. There the order is followed: of one that is a little off, the phase runs away with the angle,
from one revolution to the next. What has a phase of its own in each revolution, a tone, stays no order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.optimize import minimize_scalar

from bench.mismatch import criteria
from bench.mismatch.orders.look import PARTS
from bench.mismatch.orders.revolutions import HIGHEST_BETWEEN, Complex, Revolution, Seen
from bench.mismatch.orders.varying import varying_gain
from bench.mismatch.orders.weak import LEAK, MODELS, Stage, WeakOrder
from bench.simulation.frame import FloatArray

EXACT = 1e-6
"""orders that differ by less are one"""
SIDE_LINES = 1.5
"""orders about a summit of the energy within which its cause may stand: beside a fitted order a wave is seen at its
sides
"""
NEXT = 0.5 / PARTS
"""orders from a part of an order to the half way to the next"""
LEAST_SHARE = 0.02
"""of an order that fitted ones leave in a revolution: what is told of less is rounding and the shape of windows"""
STEPS = 4.0
"""steps while the phase of an order runs off by a revolution between the first revolution and the last"""
MOST_STEPS = 256
"""to either side of a part of an order: enough for some 1500 revolutions"""
FARTHEST = 6.0
"""times :data:`NEXT` to either side within which a found order may stand elsewhere: recordings begin where the last one
ended, in groups, and at an order that is off by one over the groups' distance the phases are nearly alike
"""
REFINED = 8
"""steps of an order that are refined: those that gain most, two of them to either side of each of a few places"""
LEAKS = 1.5
"""size of what a wave leaks into orders farther off, over the side lobes of a window of the shortest segment's length
"""
CLEAR = 3.0
"""standard deviations of the energy of noise above what an order has to gain, from which one is followed"""
MOST_SUMMITS = 192
"""summits of the energy that are looked at in a round, those that stand out most first: a motion that is not quite even
has hundreds that are no order
"""
HALF = 0.5
"""share of what stands at an order, beyond noise, that it says at least where it is an order: the rest is that of its
neighbours. A tone is heard with another phase in each revolution, and says less of itself.
"""


def is_between(order: float) -> bool:
    """Whether an order is no whole number."""
    return abs(order - round(order)) > EXACT


def search_between(
    seen: Seen,
    revolutions: Sequence[Revolution],
    train: NDArray[np.bool_],
    fitted: Sequence[float],
    floor: float,
    price: float,
    highest: float = np.inf,
) -> list[WeakOrder]:
    """Orders between the whole ones that stand in the training revolutions beside those that are ``fitted``; of those
    that leak into each other the strongest. ``floor``, ``price`` and ``highest`` as in
    :func:`bench.mismatch.orders.weak.search`.
    """
    whole = Stage.of(seen, revolutions, train)
    if whole is None:
        return []
    # a wave of less than a period in a revolution's segment is a part of its line
    lowest = 1.0 / min(t.revolutions for t in whole.revolutions)
    grid = np.arange(HIGHEST_BETWEEN * PARTS + 1) / PARTS
    shape = whole.shape[np.round(grid).astype(np.int64)]
    usable = (grid > lowest) & (grid <= highest) & (np.round(grid) != grid)
    # from each part of an order to the nearest fitted one
    off = np.min(np.abs(np.subtract.outer(grid, np.asarray(fitted))), axis=1, initial=np.inf)
    usable &= off > NEXT
    table = seen.between()[train] / whole.scale[:, None]
    # of revolutions that are noise each has 2*shape**2
    power = np.sum(np.abs(table) ** 2, axis=0)
    for near in np.flatnonzero(usable & (off < SIDE_LINES)):
        shares = whole.shares(float(grid[near]), fitted)
        usable[near] = float(np.mean(shares)) > LEAST_SHARE
        power[near] = np.sum(np.abs(table[:, near]) ** 2 / np.maximum(shares, LEAST_SHARE))
    energy = np.where(usable, power / (2.0 * shape**2) - len(whole.revolutions), -np.inf)
    usual = _usual(power / (2.0 * shape**2), len(whole.revolutions))
    path = Path.of(seen, train)
    out: list[WeakOrder] = []
    plain, least = whole.gains_of(table, shape), price + float(np.log(PARTS))
    clear = least + CLEAR * float(np.sqrt(len(whole.revolutions)))
    for _ in range(MOST_SUMMITS):
        # an order gains no more than its energy; where all about it have as much, there is no order
        k = int(np.argmax(np.where(energy > least, energy / usual, -np.inf)))
        if not energy[k] > least:
            break
        about = np.flatnonzero((np.abs(grid - grid[k]) <= SIDE_LINES) & np.isfinite(energy))
        away = np.abs(grid - grid[k])
        # of some thousand parts of an order noise has such an energy at many: where it is no more, one is not followed
        seen_at_once = energy[k] > clear or plain[about].max() > least
        line = path.best(whole, grid[about], table[:, about], shape[about], fitted) if seen_at_once else None
        if line is None or line.gain <= least:
            energy[away <= SIDE_LINES] = -np.inf
            continue
        energy[(away < LEAK) | (np.abs(grid - line.order) < LEAK)] = -np.inf
        energy -= power[k] * (LEAKS * lowest / (np.pi * np.maximum(away, LEAK))) ** 2 / (2.0 * shape**2)
        if whole.power(line) > criteria.LEAST_POWER * floor**2:
            out.append(line)
    return out


def plainly(stage: Stage, order: float) -> WeakOrder:
    """The one ``order`` of a stage, with the best of the models and its gain."""
    gain, number = stage.gains(stage.vectors)
    return stage.estimated(order, MODELS[number[0]], stage.vectors[:, 0], float(stage.shape[0]), float(gain[0]))


def _usual(energy: FloatArray, revolutions: int) -> FloatArray:
    """Energy that is usual about each part of an order (parts,), over that of noise; no less than one.

    Between the whole orders more may stand everywhere than whole orders tell: a motion that is not quite even, say.
    """
    about = median_filter(energy, round(2.0 * LEAK * PARTS) + 1, mode="mirror")
    return np.asarray(np.maximum(about / revolutions, 1.0))


@dataclass(frozen=True, slots=True)
class Path:
    """Where the training revolutions lie on the way that the output ran: mean angle ``at`` (revolutions,), and the
    steps by which an order's phase is followed from one to the next.
    """

    at: FloatArray
    step: float
    steps: FloatArray

    @property
    def price(self) -> float:
        """Log-likelihood that an order which is no part of a whole one has to gain more: it is one of many."""
        return criteria.RICHER + float(np.log(self.steps.size))

    @classmethod
    def of(cls, seen: Seen, train: NDArray[np.bool_], farther: float = 1.0) -> Path:
        """The path of the training revolutions; steps to ``farther`` times :data:`NEXT` to either side."""
        theta = [rest.theta for rest, trained in zip(seen.rest, train, strict=True) if trained]
        span = (max(float(t.max()) for t in theta) - min(float(t.min()) for t in theta)) / (2.0 * np.pi)
        step = 1.0 / (STEPS * max(span, 1.0))
        number = int(farther * min(np.ceil(NEXT / step), MOST_STEPS))
        steps = step * np.arange(-number, number + 1, dtype=np.float64)
        return cls(np.array([float(t.mean()) for t in theta]), step, steps)

    def away_from(self, order: float, others: Sequence[float]) -> Path:
        """The path without the steps that take an ``order`` next to one of the ``others``: of the two only the sum is
        seen in a revolution.
        """
        off = np.min(np.abs(np.subtract.outer(order + self.steps, np.asarray(others))), axis=1, initial=np.inf)
        # between two steps the best order is looked for
        return replace(self, steps=self.steps[(off > NEXT + self.step) | (self.steps == 0.0)])

    def rotated(self, vectors: Complex, more: FloatArray) -> Complex:
        """Vectors (revolutions,) of an order as those of orders that are ``more`` (k,) higher (revolutions, k)."""
        return np.asarray(vectors[:, None] * np.exp(-1j * self.at[:, None] * more))

    def gains(self, one: Stage, more: FloatArray) -> FloatArray:
        """Gain of orders ``more`` (k,) higher than that of a stage with one, less the price of so many steps and of
        the factors of its model (BIC).

        Recordings before a heating run and after it are apart by many revolutions, and at several orders their phases
        are alike or nearly so; at all but one the temperature has to turn them.
        """
        stage = replace(one, shape=np.full(more.size, one.shape[0]))
        gain, which = stage.gains(self.rotated(one.vectors[:, 0], more))
        factors = np.array([len(model) for model in MODELS])[which]
        return gain - np.where(more == 0.0, 0.0, self.price) - (factors - 1) * float(np.log(len(one.revolutions)))

    def told(self, one: Stage, more: float) -> float:
        """As :meth:`gains`, or with polynomials of the state where these say more."""
        at = np.array([more])
        there = replace(one, vectors=self.rotated(one.vectors[:, 0], at))
        return max(float(self.gains(one, at)[0]), varying_gain(there) - (self.price if more else 0.0))

    def stepped(self, one: Stage) -> tuple[int, float]:
        """The step at which an order gains most, and the gain."""
        gains = self.gains(one, self.steps)
        k = int(np.argmax(gains))
        return k, float(gains[k])

    def followed(self, one: Stage) -> tuple[float, float]:
        """How much higher than that of a stage an order gains most, and the gain.

        Between two steps the phase runs off by a quarter of a revolution at most: half of that, at the step next to
        it, costs a clear order more than what places where phases are nearly alike miss. So the best few are refined.
        """
        gains = self.gains(one, self.steps)
        best = (0.0, float(self.gains(one, np.zeros(1))[0]))
        for k in np.argsort(-gains)[:REFINED]:
            if self.steps[k] == 0.0:
                continue
            found = minimize_scalar(
                lambda d: -float(self.gains(one, np.array([d]))[0]),
                bounds=(self.steps[k] - self.step, self.steps[k] + self.step),
                method="bounded",
                options={"xatol": 0.001 * self.step},
            )
            best = max(best, (float(found.x), -float(found.fun)), key=lambda at: at[1])
        return best

    def best(
        self, whole: Stage, orders: FloatArray, vectors: Complex, shape: FloatArray, fitted: Sequence[float]
    ) -> WeakOrder | None:
        """The order at or about some ``orders`` (k,), ``vectors`` (revolutions, k), that gains most; None where it says
        less than half of what stands there.
        """
        stages = [beside(whole, float(f), fitted, vectors[:, i], float(shape[i])) for i, f in enumerate(orders)]
        k = int(np.argmax([self.stepped(one)[1] for one in stages]))
        more = self.away_from(float(orders[k]), fitted).followed(stages[k])[0]
        order, stage = float(orders[k]), stages[k]
        if more:
            order = rounded(float(orders[k]) + more)
            rotated = self.rotated(vectors[:, k], np.array([more]))[:, 0]
            stage = beside(whole, order, fitted, rotated, float(shape[k]))
        line = plainly(stage, order)
        line = replace(line, gain=line.gain - (self.price if more else 0.0))
        nearest = int(np.argmin(np.abs(orders - order)))
        plain = plainly(stages[nearest], float(orders[nearest]))
        if plain.gain >= line.gain:
            line, stage = plain, stages[nearest]
        return line if _explained_share(stage, line) >= HALF else None


def rounded(order: float) -> float:
    """An order in so many digits that its phase is right to a hundredth after thousands of revolutions."""
    return float(f"{order:.9g}")


def _explained_share(one: Stage, line: WeakOrder) -> float:
    """Share of the energy at a stage's one order, beyond that of noise, which a line explains."""
    energy = float(np.sum(np.abs(one.vectors) ** 2))
    noise = 2.0 * float(one.shape[0]) ** 2 * len(one.revolutions)
    left = one.misfit(line, one.vectors[:, 0], float(one.shape[0])) * noise
    return 1.0 - (left - noise) / max(energy - noise, 1e-300)


def left_of(whole: Stage, order: float, fitted: Sequence[float]) -> FloatArray:
    """Share of an order's amplitude that the ``fitted`` orders leave of it in each revolution (revolutions,)."""
    return np.asarray(np.sqrt(np.maximum(whole.shares(order, fitted), LEAST_SHARE)))


def beside(whole: Stage, order: float, fitted: Sequence[float], vectors: Complex, sigma: float) -> Stage:
    """The training revolutions at one order alone, whose residual ``vectors`` (revolutions,) are what the ``fitted``
    orders leave of it: in each as sure as the part that they leave.
    """
    left = left_of(whole, order, fitted)
    return whole.rescaled((vectors / left)[:, None], whole.scale / left, np.array([sigma]))
