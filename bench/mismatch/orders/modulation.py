"""Sidebands: pairs of orders about a known one that are more than two plain orders which happen to lie so.

A pair is recognised by its sizes (both sides are alike, and of a size of their own among the orders of this gearbox)
and by its vectors (constant, or in proportion to the carrier's or to each other as they move with the state), each as a
log-likelihood against two plain orders. Among many orders some pair lies about a known order by chance: the orders
found are put elsewhere at random, where orders are as dense, and the best pair sought again, hundreds of times.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.revolutions import Complex, passed
from bench.mismatch.orders.sight import Sight
from bench.mismatch.orders.weak import NEIGHBOUR_REVOLUTIONS, design
from bench.simulation.frame import FloatArray, IntArray
from bench.simulation.laws import RESONANCE

MULTIPLES = 3
"""of a modulation's order at which further pairs belong to it"""
SCATTER = 1.0
"""the same of a gearbox's orders among each other, before this one's are seen, and how many orders' worth that is"""
SCATTER_ORDERS = 4.0
USUAL_ORDERS = 20.0
"""orders' worth of evidence that orders may stand anywhere"""
SURROGATES = 2000


@dataclass(frozen=True, slots=True)
class Pair:
    """A carrier, the modulation's order, the two orders (None: the model has that order already), whether their vectors
    follow the carrier's.
    """

    carrier: float
    modulation: float
    orders: tuple[float, ...]
    follows: bool
    gain: float


@dataclass(frozen=True, slots=True)
class Modulation:
    """Pairs of one carrier; ``p_value``: share of random places of the orders in which some pair looks as good."""

    pairs: tuple[Pair, ...]
    p_value: float

    @property
    def orders(self) -> tuple[float, ...]:
        """All orders of the pairs."""
        return tuple(f for pair in self.pairs for f in pair.orders)


@dataclass(frozen=True, slots=True)
class _Orders:
    """Found whole orders (n,): number, logarithm of the size over what is usual there; what a constant vector loses
    against the best plain model, what one in proportion to each carrier's gains against it (n, carriers), and one in
    proportion to what the plain model of each other order says (n, n).
    """

    number: IntArray
    size: FloatArray
    constant: FloatArray
    following: FloatArray
    together: FloatArray
    carriers: tuple[float, ...]
    highest: int


def search(model: TransmissionModel, sight: Sight, taken: Sequence[float], seed: int) -> Modulation | None:
    """The best modulation of a known order, if chance does not place orders so; orders ``taken`` are none of it."""
    found = _found(model, sight, taken)
    if found.number.size < 2:
        return None
    score, pairs = _best(found, found.number)
    if pairs is None:
        return None
    rng = np.random.default_rng([seed, 3])
    density = _density(found, sight)
    better = 0
    for _ in range(SURROGATES):
        orders = rng.choice(density.size, found.number.size, replace=False, p=density)
        better += _best(found, orders)[0] >= score
    p_value = (1.0 + better) / (1.0 + SURROGATES)
    alone = found.number.size == 2 * len(pairs)
    return Modulation(pairs, p_value) if p_value < (criteria.PAIR_ALONE if alone else criteria.ERROR_RATE) else None


def _found(model: TransmissionModel, sight: Sight, taken: Sequence[float]) -> _Orders:
    assert model.periodic is not None
    candidates = [f for f in sight.found if f == round(f) and f not in taken]
    carriers = tuple(f for f in model.given.orders if f not in model.given.notch and f in model.periodic.series.orders)
    revolutions = model.training_revolutions
    # what all orders near a mode pass makes none the sideband of another: they are compared as they were before it
    modes = [law for law in model.periodic.laws if law.effect == RESONANCE]
    shown = (
        model.periodic.at_revolutions(revolutions, carriers)
        / sight.stage.scale[:, None]
        / passed(modes, revolutions, carriers)
    )
    by = passed(modes, revolutions, candidates)
    size, constant = np.zeros(len(candidates)), np.zeros(len(candidates))
    following = np.full((len(candidates), len(carriers)), -np.inf)
    shown_of: list[tuple[Complex, float, float]] = []
    said: list[Complex] = []
    for k, f in enumerate(candidates):
        vectors = sight.at(model, f) / by[:, k]
        best, which = sight.gains(vectors, f)
        estimate = sight.estimated(vectors, f, which, best)
        noise = sight.noise(f)
        shown_of.append((vectors, noise, best))
        said.append(estimate.at(design(estimate.model, revolutions)) / sight.stage.scale)
        level = 1.0 / sight.stage.scale
        constant[k] = min(_proportional(vectors, level.astype(np.complex128), noise) - best, 0.0)
        size[k] = 0.5 * np.log(np.mean(np.abs(vectors * sight.stage.scale) ** 2))
        for c in range(len(carriers)):
            following[k, c] = _proportional(vectors, shown[:, c], noise) - best
    together = np.array([[_proportional(v, to, noise) - best for to in said] for v, noise, best in shown_of])
    highest = int(max([*candidates, *carriers, 1.0]) * 1.1) + criteria.HIGHEST_MODULATION
    orders = np.array(candidates, dtype=np.int64)
    return _Orders(orders, _beyond_usual(orders, size), constant, following, together, carriers, highest)


def _beyond_usual(orders: IntArray, size: FloatArray) -> FloatArray:
    """Logarithm of the sizes (n,) less their fall with the order: a gearbox' low orders are larger, and two large ones
    about a low carrier no surprise. The fall is that of the orders found, drawn towards none where they are few.
    """
    if orders.size == 0:
        return size
    x = np.log(orders.astype(np.float64))
    x = x - x.mean()
    fall = float(x @ (size - size.mean())) / (float(x @ x) + SCATTER**2)
    return np.asarray(size - fall * x)


def _proportional(vectors: Complex, to: Complex, noise: float) -> float:
    """Gain of vectors (revolutions,) in proportion to others, each revolution predicted by the rest."""
    energy = np.abs(to) ** 2
    ratio = np.sum(np.conj(to) * vectors) / max(float(energy.sum()), 1e-300)
    leverage = np.minimum(energy / max(float(energy.sum()), 1e-300), 0.99)
    left = float(np.sum(np.abs((vectors - ratio * to) / (1.0 - leverage)) ** 2))
    prior = 2.0 * NEIGHBOUR_REVOLUTIONS * noise**2
    before = float(np.sum(np.abs(vectors) ** 2))
    return float((vectors.size + NEIGHBOUR_REVOLUTIONS) * np.log((before + prior) / (left + prior)))


def _density(found: _Orders, sight: Sight) -> FloatArray:
    """Chance that an order stands at each place (highest + 1,): anywhere, or where those of this gearbox are dense."""
    orders = np.arange(found.highest + 1.0)
    usual = 1.0 / (15.0 + orders)
    out = USUAL_ORDERS * usual / usual.sum()
    for f in found.number:
        width = 0.3 * float(f) + 3.0
        kernel = np.exp(-0.5 * ((orders - f) / width) ** 2)
        out += kernel / kernel.sum()
    out[0] = 0.0
    out[[round(f) for f in sight.known if f < out.size - 0.5]] = 0.0
    return np.asarray(out / out.sum())


def _best(found: _Orders, orders: IntArray) -> tuple[float, tuple[Pair, ...] | None]:
    """The best modulation with the orders at some ``orders``: its score, and its pairs."""
    steps = np.arange(1, criteria.HIGHEST_MODULATION * MULTIPLES + 1)
    at = np.full(found.highest + steps.size + 1, -1, dtype=np.int64)
    at[orders] = np.arange(orders.size)
    carriers = np.array(found.carriers)
    whole = carriers == np.round(carriers)
    centre = np.where(whole, carriers, 0.0).astype(np.int64)[:, None]
    lower = at[np.maximum(centre - steps, 0)]
    upper = at[np.minimum(centre + steps, at.size - 1)]
    scored: dict[int, dict[int, tuple[float, bool]]] = {}
    spread, mean = _scatter(found.size)
    for c, k in np.argwhere((lower >= 0) & (upper >= 0) & (centre > steps)).tolist():
        scored_pair = _score(found, c, int(lower[c, k]), int(upper[c, k]), spread, mean)
        scored.setdefault(c, {})[int(steps[k])] = scored_pair
    best: tuple[float, tuple[Pair, ...] | None] = (-np.inf, None)
    for c, pairs in scored.items():
        for m in pairs:
            if m > criteria.HIGHEST_MODULATION or criteria.NARROW * m > found.carriers[c]:
                continue
            family = [m] + [q * m for q in range(2, MULTIPLES + 1) if q * m in pairs and pairs[q * m][0] > 0.0]
            total = sum(pairs[q][0] for q in family)
            if total > best[0]:
                f = found.carriers[c]
                best = (total, tuple(Pair(f, float(q), (f - q, f + q), pairs[q][1], pairs[q][0]) for q in family))
    return best


def _scatter(size: FloatArray) -> tuple[float, float]:
    """Spread and mean of the logarithm of the orders' sizes."""
    mean = float(np.median(size))
    square = float(np.sum((size - mean) ** 2)) + SCATTER_ORDERS * SCATTER**2
    return float(np.sqrt(square / (size.size + SCATTER_ORDERS))), mean


def _score(found: _Orders, c: int, low: int, high: int, spread: float, mean: float) -> tuple[float, bool]:
    """Log-likelihood of a pair against two plain orders; whether its vectors follow the carrier's."""
    a, b = float(found.size[low]), float(found.size[high])
    plain = -0.5 * ((a - mean) ** 2 + (b - mean) ** 2) / spread**2 - 2.0 * np.log(spread)
    # a modulation may have any size: that of one order, but three times as far from the others'
    middle = 0.5 * (a + b)
    wide = 3.0 * spread
    ours = (
        -0.5 * ((middle - mean) / wide) ** 2
        - np.log(wide)
        - 0.5 * ((a - b) / criteria.SIDES_ALIKE) ** 2
        - np.log(criteria.SIDES_ALIKE)
    )
    constant = float(found.constant[low] + found.constant[high])
    following = float(found.following[low, c] + found.following[high, c])
    # both as one of them moves with the state: what modulates is no constant
    together = min(float(max(found.together[low, high], found.together[high, low])), 0.0)
    alike = max(constant, together)
    return ours - plain + max(alike, following), following > alike


def ratios(model: TransmissionModel, sight: Sight, pair: Pair) -> dict[float, tuple[complex, float]]:
    """Each order's vector over its carrier's, and the standard deviation of a component of that."""
    assert model.periodic is not None
    revolutions = model.training_revolutions
    to = model.periodic.at_revolutions(revolutions, [pair.carrier])[:, 0] / sight.stage.scale
    energy = float(np.sum(np.abs(to) ** 2))
    out = {}
    for f in pair.orders:
        vectors = sight.at(model, f)
        ratio = complex(np.sum(np.conj(to) * vectors) / energy)
        left = float(np.sum(np.abs(vectors - ratio * to) ** 2)) / (2.0 * max(vectors.size - 1, 1))
        out[f] = (ratio, float(np.sqrt(max(left, sight.noise(f) ** 2) / energy)))
    return out
