"""The series and further orders of the transmission error, calibrated on what its revolutions show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch.orders.corner import cornered
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.partial import refined
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.orders.revolutions import Complex, Seen, passed
from bench.mismatch.orders.series import Series, calibrate
from bench.mismatch.orders.weak import Stage, WeakOrder
from bench.simulation.frame import FloatArray
from bench.simulation.laws import Law

FOLLOWED = 2.0
"""variance of what a plain model leaves of an order's vectors, over the noise's, from which the order gets
polynomials of its own"""


def calibrate_all(model: TransmissionModel, now: Seen, known: Sequence[float], found: dict[float, WeakOrder]) -> None:
    """Calibrate the series and the further orders on what the revolutions show of them all."""
    stage = Stage.of(now, model.revolutions, model.train)
    # what is found under a law follows it, as the series does
    polynomial = list(known)
    weak: list[WeakOrder] = []
    for f, order in found.items():
        k = now.orders.index(f)
        if stage is None:
            continue
        vectors = now.vectors[model.train, k] / stage.scale
        sigma = stage.shape_at(f)
        estimate = stage.estimated(f, order.model, vectors, sigma, order.gain)
        if model.laws or stage.misfit(estimate, vectors, sigma) > FOLLOWED:
            polynomial.append(f)
        weak.append(estimate)
    revolutions = model.training_revolutions
    model.seen = now
    if stage is not None and not model.laws:
        bent = _bent(model, now, stage, [w for w in weak if w.order in polynomial])
        weak = [bent.get(w.order, w) for w in weak]
        polynomial = [f for f in polynomial if f not in bent]
    columns = np.array([now.orders.index(f) for f in polynomial], dtype=np.int64)
    noise = now.noise(polynomial)[model.train]
    vectors = now.vectors[model.train][:, columns]
    alone = tuple(w for w in weak if w.order not in polynomial)

    def under(laws: tuple[Law, ...], waves: tuple[WeakOrder, ...]) -> Periodic:
        series = calibrated_by(model, vectors, noise, polynomial, passed(laws, revolutions, polynomial))
        return with_parts(model, Periodic(series, waves, laws=laws))

    model.periodic = under((*model.given.laws, *model.laws), alone)
    given = under(model.given.laws, alone) if model.laws else model.periodic
    model.plain = given.series.less([f for f in polynomial if f not in known])


def _bent(model: TransmissionModel, now: Seen, stage: Stage, asked: Sequence[WeakOrder]) -> dict[float, WeakOrder]:
    """Of found orders that are to have polynomials those that waves over the torque follow better, as such."""
    if not asked:
        return {}
    orders = [w.order for w in asked]
    columns = [now.orders.index(f) for f in orders]
    noise, vectors = now.noise(orders)[model.train], now.vectors[model.train][:, columns]
    series = calibrated_by(model, vectors, noise, orders, np.ones_like(vectors))
    points = model.folds[[t.recording for t in model.training_revolutions]]
    found = (cornered(w, stage, vectors[:, k], series, noise[:, k], points) for k, w in enumerate(asked))
    return {w.order: w for w in found if w is not None}


def calibrated_by(
    model: TransmissionModel, vectors: Complex, noise: FloatArray, orders: Sequence[float], by: Complex
) -> Series:
    """The series of ``vectors`` (revolutions, orders) of the training revolutions whose components have ``noise``,
    before something multiplies them ``by`` a response (revolutions, orders).
    """
    given = {*model.given.orders, *model.given.notch}
    return calibrate(model.training_revolutions, vectors / by, noise / np.abs(by), orders, model.parts, given)


def with_parts(model: TransmissionModel, periodic: Periodic) -> Periodic:
    """What is periodic with what the steady parts of less than a revolution say of its series."""
    if not model.parts or model.seen is None or not periodic.series.orders:
        return periodic
    rest = replace(periodic, series=periodic.series.less(periodic.series.orders), laws=())
    rest_of_rows = model.without_offset.copy()
    for part in model.parts:
        rest_of_rows[part.rows] -= rest.evaluate(model.rows.frame.take(part.rows))
    white = float(np.median(model.seen.white[model.train]))
    return replace(
        periodic, series=refined(periodic.series, model.rows, rest_of_rows, model.parts, white, periodic.laws)
    )
