"""Orders of a gearbox that pass a mode, looked for under it.

A mode makes a weak order large at the one speed that excites it and leaves it small at all others: it is no order of
one vector, and what it leaves leaks into orders that are none. So the orders are looked for once more, from
the simulation's own on, with the response of the mode in what each would draw. Then the mode is fitted again: an order
of the simulation may vary with the speed by its polynomials, an order that was found has one vector.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.orders import modes
from bench.mismatch.orders.borne_out import borne_out
from bench.mismatch.orders.calibrating import calibrate_all
from bench.mismatch.orders.joint import Evidence, settled
from bench.mismatch.orders.law_scores import amplitudes
from bench.mismatch.orders.laws import FoundLaw
from bench.mismatch.orders.look import PARTS, Look
from bench.mismatch.orders.model import TransmissionModel, steady_rows, with_noise
from bench.mismatch.orders.modes import Mode
from bench.mismatch.orders.periodic import Periodic, Pulse
from bench.mismatch.orders.revolutions import Complex, Seen, directions, looks, passed, seen, states
from bench.mismatch.orders.turns import ROUNDS, level_of
from bench.mismatch.orders.weak import LEAK, Stage, WeakOrder, gain_of
from bench.simulation.frame import FloatArray
from bench.simulation.laws import MODES, Law, resonant

STRONG = 2.0
"""root mean square of what a mode adds to the revolutions, over the noise of a sample, from which it hides orders where
none beside the simulation's was found
"""
PASSES = 2
"""times that orders and mode are found in turns"""
MOST_LEVERAGE = 0.99
"""of a revolution that alone tells a vector: it says nothing of another"""
PLAIN = (("1",), ("p", "n"))
"""factors of an order under a mode: one vector, or one in each direction"""
PassedMode = tuple[FoundLaw, Periodic]
"""a mode that orders pass, and what is periodic without it"""


def hides(model: TransmissionModel, found: FoundLaw) -> bool:
    """Whether a mode hides orders, and makes others of what it leaves: there are some beside the simulation's, of one
    vector and therefore not under it; or it adds so much that none need have been seen.
    """
    assert model.noise is not None
    assert model.periodic is not None
    if model.periodic.weak:
        return True
    revolutions, orders = model.training_revolutions, found.series.orders
    vectors = found.series.vectors(states(revolutions), directions(revolutions))
    added = vectors * (passed([found.law], revolutions, orders) - 1.0)
    power = float(np.mean(0.5 * np.sum(np.abs(added) ** 2, axis=1)))
    return power > STRONG**2 * model.noise.variance


def under(model: TransmissionModel, found: FoundLaw, plain: Periodic) -> PassedMode | None:
    """Orders and mode found in turns; the mode as it is then, and what is periodic without it.

    ``model`` then holds them; None, and the model as it was, where they leave more than ``plain``, the orders that were
    found without the mode, with it.
    """
    before = replace(model)
    y = model.without_offset
    least = _left(model, y, plain)
    look = _Search(model, looks(model.rows, model.revolutions))
    law, best = found.law, None
    guess = _found(plain, look.known)
    for _ in range(PASSES):
        best = look.once(y, law, guess)
        if best is None:
            break
        law, guess = best.mode.law, best.orders
        assert model.periodic is not None
        y = model.toneless - level_of(model)
    periodic = model.periodic
    if (
        best is not None
        and periodic is not None
        and _left(model, y, periodic) <= least
        and (before.periodic is None or borne_out(model, before.periodic, periodic, True))
    ):
        model.quiet = y
        with_noise(model, best.seen)
        return replace(found, law=model.laws[0], std=best.mode.std, series=periodic.series), best.without
    model.restore(before)
    return None


def beside(model: TransmissionModel, found: FoundLaw, pulses: Sequence[Pulse]) -> PassedMode | None:
    """Orders and the mode that was ``found`` as they are beside some pulses: orders that the pulses have drawn go. What
    is periodic without the mode has the pulses, the model then as well; None, and the model as it was, where nothing is
    left of the mode.
    """
    before, periodic = replace(model), model.periodic
    assert periodic is not None
    look = _Search(model, looks(model.rows, model.revolutions))
    theta = model.rows.frame.theta
    y = model.without_offset - sum((p.evaluate(theta) for p in pulses), np.zeros(theta.size))
    best = look.once(y, found.law, _found(periodic, look.known))
    if best is None or model.periodic is None:
        model.restore(before)
        return None
    model.periodic = replace(model.periodic, pulses=tuple(pulses))
    law = replace(found, law=model.laws[0], std=best.mode.std, series=model.periodic.series)
    return law, replace(best.without, pulses=tuple(pulses))


def _found(periodic: Periodic, known: Sequence[float]) -> dict[float, WeakOrder]:
    """Orders of what is periodic that are not ``known``."""
    none = np.zeros(0, dtype=np.complex128)
    beside = (f for f in periodic.series.orders if f not in known)
    return {w.order: w for w in periodic.weak} | {f: WeakOrder(f, PLAIN[1], none, np.zeros(0), 0.0) for f in beside}


def passes(model: TransmissionModel, stage: Stage, order: float) -> bool:
    """Whether a found order has rather passed the model's strong mode than stands beside it, as what an encoder
    misreads does.
    """
    assert model.seen is not None
    vectors = model.seen.vectors[model.train, model.seen.orders.index(order)][:, None] / stage.scale[:, None]
    law, at = model.laws[0], np.array([order])
    beside = replace(law, point=(*law.point[:2], 0.0))
    return bool(_gains(stage, vectors, at, law)[0][0] > _gains(stage, vectors, at, beside)[0][0])


def _left(model: TransmissionModel, y: FloatArray, periodic: Periodic) -> float:
    """Mean square of what is left of ``y`` (n,) in the steady rows that may be fitted."""
    rows = np.flatnonzero(steady_rows(model) & (model.folds[model.rows.frame.recording] >= 0))
    left = y[rows] - periodic.evaluate(model.rows.frame)[rows]
    return float(np.average(left**2, weights=model.rows.number[rows]))


@dataclass(frozen=True, slots=True)
class _Under:
    """A mode, what the revolutions show of the orders under it, what is periodic without the mode, and the orders
    beside the known ones.
    """

    mode: Mode
    seen: Seen
    without: Periodic
    orders: dict[float, WeakOrder]


@dataclass(frozen=True, slots=True)
class _Search:
    """A model and the rows of its revolutions."""

    model: TransmissionModel
    shown: tuple[Look, ...]

    @property
    def known(self) -> list[float]:
        given = self.model.given
        return [*given.orders, *(f for f in given.notch if f not in given.orders)]

    def once(self, y: FloatArray, law: Law, guess: Mapping[float, WeakOrder]) -> _Under | None:
        """Find the orders of ``y`` (n,) under a mode from a ``guess`` on, then the mode anew; the model is calibrated
        with both.
        """
        model, known = self.model, self.known
        orders, now = self._orders(y, law, guess)
        model.laws = ()
        calibrate_all(model, now, known, orders)
        without, mode = model.periodic, self._mode(now, orders, law)
        if mode is None or without is None:
            return None
        every = tuple(f for f in now.orders if f not in model.given.notch)
        none = np.zeros(len(every), dtype=np.complex128)
        model.laws = (replace(mode.law, orders=every, series=every, strength=none),)
        calibrate_all(model, now, known, orders)
        return _Under(mode, now, without, orders)

    def _orders(self, y: FloatArray, law: Law, guess: Mapping[float, WeakOrder]) -> tuple[dict[float, WeakOrder], Seen]:
        """Orders that stand in the revolutions under a mode beside the known ones, and what these show of all."""
        model, found = self.model, dict(guess)
        speed = states(model.training_revolutions)[:, 1]

        def look(at: Collection[float]) -> Seen:
            return seen(self.shown, model.revolutions, y, [*self.known, *sorted(at)])

        def answer(order: float) -> Complex:
            return np.asarray(resonant(law.form, speed * order, law.point))

        def in_place(now: Seen) -> Seen:
            assert model.price is not None
            return settled(look, now, found, Evidence(model.revolutions, model.train, model.price, answer))

        now = in_place(look(found))
        for _ in range(ROUNDS):
            stage = Stage.of(now, model.revolutions, model.train)
            if stage is None or model.price is None or model.noise is None:
                break
            floor = float(np.sqrt(model.noise.variance))
            whole = np.arange(stage.vectors.shape[1], dtype=np.float64)
            fresh = _significant(stage, stage.vectors, whole, law, now.orders, floor, model.price)
            if not fresh:
                between = now.between()[model.train] / stage.scale[:, None]
                parts = np.arange(between.shape[1]) / PARTS
                price = model.price + float(np.log(PARTS))
                fresh = _apart(_significant(stage, between, parts, law, now.orders, floor, price))
            fresh = [w for w in fresh if w.order not in found]
            if not fresh:
                break
            found |= {w.order: w for w in fresh}
            now = look(found)
        return found, in_place(now)

    def _mode(self, now: Seen, orders: Mapping[float, WeakOrder], law: Law) -> Mode | None:
        """The mode that the simulation's orders and those found beside them pass; of all forms the best."""
        model = self.model
        data, stage = amplitudes(model), Stage.of(now, model.revolutions, model.train)
        if data is None or stage is None:
            return None
        kept = [k for k, f in enumerate(data.orders) if f in self.known]
        series = data.series.less([f for f in data.orders if f not in self.known])
        data = replace(
            data, vectors=data.vectors[:, kept], sigma=data.sigma[:, kept], orders=series.orders, series=series
        )
        weak = np.array(sorted(orders))
        vectors = now.vectors[model.train][:, [now.orders.index(f) for f in weak]] / stage.scale[:, None]

        def beside(tried: Law) -> float:
            return float(np.sum(_gains(stage, vectors, weak, tried)[0]))

        found = [modes.refined(model, data, replace(law, form=form, orders=data.orders), beside) for form in MODES]
        return max(found, key=lambda m: m.gain)


def _apart(lines: Sequence[WeakOrder]) -> list[WeakOrder]:
    """Those between whole orders, of which one leaks into the next the strongest alone."""
    out: list[WeakOrder] = []
    for line in lines:
        if line.order != round(line.order) and all(abs(line.order - other.order) >= LEAK for other in out):
            out.append(line)
    return out


def _significant(
    stage: Stage,
    vectors: Complex,
    orders: FloatArray,
    law: Law,
    fitted: Sequence[float],
    floor: float,
    price: float,
) -> list[WeakOrder]:
    """Orders (k,) whose ``vectors`` (revolutions, k), over the revolutions' scale, gain more than a ``price`` under a
    mode; of neighbours the strongest, strongest first.
    """
    best, which, held = _gains(stage, vectors, orders, law)
    usable = (held > criteria.LEAST_POWER * floor**2) & (orders >= 1.0)
    for f in fitted:
        usable &= np.abs(orders - f) > 0.5 / PARTS
    best = np.where(usable, best, -np.inf)
    out = []
    for k in np.flatnonzero(best > price):
        # what is strong leaks into its neighbours until it has been fitted
        if best[k] >= best[np.abs(orders - orders[k]) <= 2.0].max():
            none = np.zeros(0, dtype=np.complex128)
            out.append(WeakOrder(float(orders[k]), PLAIN[which[k]], none, np.zeros(0), float(best[k])))
    return sorted(out, key=lambda w: -w.gain)


def _gains(
    stage: Stage, vectors: Complex, orders: FloatArray, law: Law
) -> tuple[FloatArray, NDArray[np.int64], FloatArray]:
    """Gain of log-likelihood (k,) of the better of :data:`PLAIN` under a mode, which it is, mean square of its wave."""
    x, side = states(stage.revolutions), directions(stage.revolutions)
    by = resonant(law.form, x[:, 1][:, None] * orders[None, :], law.point) / stage.scale[:, None]
    shape = stage.shape[np.minimum(np.round(orders).astype(np.int64), stage.shape.size - 1)]
    energy = np.sum(np.abs(vectors) ** 2, axis=0)
    best, which, held = np.full(orders.size, -np.inf), np.zeros(orders.size, dtype=np.int64), np.zeros(orders.size)
    for number, groups in enumerate(([np.ones(side.size, dtype=bool)], [side > 0, side <= 0])):
        left, power = vectors.copy(), np.zeros(orders.size)
        for group in (g for g in groups if g.any()):
            weight = np.sum(np.abs(by[group]) ** 2, axis=0)
            value = np.sum(np.conj(by[group]) * vectors[group], axis=0) / weight
            leverage = np.minimum(np.abs(by[group]) ** 2 / weight, MOST_LEVERAGE)
            left[group] = (vectors[group] - by[group] * value) / (1.0 - leverage)
            power += 0.5 * np.sum(np.abs(by[group] * value * stage.scale[group][:, None]) ** 2, axis=0) / side.size
        gain = gain_of(energy, np.sum(np.abs(left) ** 2, axis=0), side.size, shape)
        better = gain > best + (0.0 if number == 0 else criteria.RICHER)
        best, which, held = np.where(better, gain, best), np.where(better, number, which), np.where(better, power, held)
    return best, which, held
