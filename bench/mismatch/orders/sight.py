"""What the training revolutions show of every whole order, whatever of it is already known as an order.

Pulses, pairs and laws are looked for in the same vectors as plain orders, with the orders that they would draw put
back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.orders.calibrating import calibrate_all
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.periodic import Periodic, Pulse
from bench.mismatch.orders.revolutions import Complex, Seen
from bench.mismatch.orders.weak import MODELS, Stage, WeakOrder, search
from bench.simulation.frame import FloatArray

ROUNDS = 4
"""neighbours of what was found are found in the next round"""


@dataclass(frozen=True, slots=True)
class Sight:
    """Orders ``found`` beside the ``known`` ones; the training revolutions as ``stage``, whose vectors (revolutions,
    orders) have the found whole orders put back, over the revolutions' scale; ``mean`` (orders,) of the vectors over
    the revolutions, ``error`` (orders,) standard deviation of a component of it; ``free`` (orders,) no known order.
    """

    known: tuple[float, ...]
    found: tuple[float, ...]
    stage: Stage
    mean: Complex
    error: FloatArray
    free: NDArray[np.bool_]

    @classmethod
    def of(cls, model: TransmissionModel) -> Sight | None:
        """Look at a model's revolutions; None where they are too few."""
        seen = model.seen
        if seen is None or model.periodic is None:
            return None
        known = known_orders(model)
        stage = Stage.of(put_back(_without_modes(model, seen), known), model.revolutions, model.train)
        if stage is None:
            return None
        weight = 1.0 / stage.scale
        energy = float(np.sum(weight**2))
        free = np.ones(stage.shape.size, dtype=bool)
        free[[0, *(round(f) for f in known if f < free.size - 0.5)]] = False
        mean = weight @ stage.vectors / energy
        error = stage.shape / np.sqrt(energy)
        return cls(known, tuple(f for f in seen.orders if f not in known), stage, mean, error, free)

    def at(self, model: TransmissionModel, order: float) -> Complex:
        """Vectors of a found order in the training revolutions (revolutions,), over the revolutions' scale."""
        assert model.seen is not None
        return np.asarray(model.seen.vectors[model.train, model.seen.orders.index(order)] / self.stage.scale)

    def noise(self, order: float) -> float:
        """Standard deviation of a component at an order, over the revolutions' scale."""
        return float(self.stage.shape[min(round(order), self.stage.shape.size - 1)])

    def gains(self, vectors: Complex, order: float) -> tuple[float, int]:
        """Gain of an order's best model from its ``vectors`` (revolutions,), and which of :data:`MODELS` it is."""
        gain, which = self._alone(order).gains(vectors[:, None])
        return float(gain[0]), int(which[0])

    def estimated(self, vectors: Complex, order: float, which: int, gain: float) -> WeakOrder:
        """The order's waves by one of :data:`MODELS`."""
        return self.stage.estimated(order, MODELS[which], vectors, self.noise(order), gain)

    def _alone(self, order: float) -> Stage:
        index = min(round(order), self.stage.shape.size - 1)
        return replace(self.stage, shape=self.stage.shape[index : index + 1])


def known_orders(model: TransmissionModel) -> tuple[float, ...]:
    """Orders of the given simulation, those of the load motor's ripple with them."""
    given = model.given
    return (*given.orders, *(f for f in given.notch if f not in given.orders))


def _without_modes(model: TransmissionModel, seen: Seen) -> Seen:
    """The same with the orders' vectors as they would be without the modes that orders were looked for under."""
    periodic = model.periodic
    assert periodic is not None
    columns = [k for k, f in enumerate(seen.orders) if f in periodic.series.orders]
    orders, revolutions = [seen.orders[k] for k in columns], model.revolutions
    if not model.laws or not orders:
        return seen
    less = replace(periodic, laws=tuple(law for law in periodic.laws if law not in model.laws))
    vectors = seen.vectors.copy()
    vectors[:, columns] -= periodic.at_revolutions(revolutions, orders) - less.at_revolutions(revolutions, orders)
    return replace(seen, vectors=vectors)


def put_back(seen: Seen, known: Sequence[float]) -> Seen:
    """The same with what was fitted at found whole orders standing in the residual."""
    left = seen.left.copy()
    for k, f in enumerate(seen.orders):
        if f not in known and _whole(f) and f < left.shape[1]:
            left[:, round(f)] += seen.vectors[:, k]
    return replace(seen, left=left)


def without(seen: Seen, known: Sequence[float], pulses: Sequence[Pulse]) -> Seen:
    """The revolutions less some pulses: vectors of the known orders, and everything else in the residual."""
    whole = put_back(seen, known)
    kept = [k for k, f in enumerate(seen.orders) if f in known or not _whole(f)]
    orders = tuple(seen.orders[k] for k in kept)
    vectors, left = seen.vectors[:, kept].copy(), whole.left.copy()
    fitted = {round(f) for f in orders if _whole(f)}
    every = np.arange(left.shape[1], dtype=np.float64)
    rest = np.array([k not in fitted for k in range(every.size)])
    for pulse in pulses:
        drawn = pulse.vectors(every)
        left[:, rest] -= drawn[rest]
        vectors -= np.array([drawn[round(f)] if _whole(f) and f < every.size else 0.0 for f in orders])
    return Seen(orders, vectors, left, seen.sigma, seen.white, seen.rest)


def rebuilt(model: TransmissionModel, pulses: Sequence[Pulse]) -> None:
    """Calibrate a model anew with some pulses in it: orders that they have drawn go, others stay or come."""
    assert model.seen is not None
    assert model.noise is not None
    assert model.price is not None
    known = known_orders(model)
    base = without(model.seen, known, pulses)
    floor = float(np.sqrt(model.noise.variance))
    found: dict[float, WeakOrder] = {}
    # what has no whole number of periods in a revolution cannot be a pulse's: it stays
    kept = {f: k for k, f in enumerate(base.orders) if f not in known}
    stage = Stage.of(base, model.revolutions, model.train)
    assert stage is not None
    for f, k in kept.items():
        index = min(round(f), stage.shape.size - 1)
        vectors = base.vectors[model.train, k] / stage.scale
        gain, which = replace(stage, shape=stage.shape[index : index + 1]).gains(vectors[:, None])
        found[f] = stage.estimated(f, MODELS[int(which[0])], vectors, float(stage.shape[index]), float(gain[0]))
    for _ in range(ROUNDS):
        fresh = search(base, model.revolutions, model.train, [*base.orders, *found], floor, model.price)
        fresh = [w for w in fresh if w.order not in found]
        if not fresh:
            break
        found |= {w.order: w for w in fresh}
    whole = [f for f in found if f not in kept]
    orders = [round(f) for f in whole]
    left = base.left.copy()
    left[:, orders] = 0.0
    now = Seen(
        (*base.orders, *whole), np.hstack([base.vectors, base.left[:, orders]]), left, base.sigma, base.white, base.rest
    )
    calibrate_all(model, now, known, found)
    assert model.periodic is not None
    model.periodic = replace(model.periodic, pulses=tuple(pulses))


def added(model: TransmissionModel, less: Periodic) -> FloatArray:
    """What a model's periodic part says beyond another, at the model's rows (n,)."""
    assert model.periodic is not None
    frame = model.rows.frame
    return np.asarray(model.periodic.evaluate(frame) - less.evaluate(frame))


def _whole(order: float) -> bool:
    return order == round(order)
