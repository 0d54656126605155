"""Laws that the amplitudes of the known orders follow beyond the paper's quadratic polynomials.

A law multiplies an order's vector: a resonance by 1 + p*(H(f*|v|) - 1), every other by 1 + e*g with g of speed,
temperature, time or load and e of each order. The polynomials' coefficients are free beside it, with the spread that
the orders themselves have shown (their tangent is part of the noise), so nothing counts that a calibration could
absorb. What the best of all laws gains in noise is measured on draws of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from bench.mismatch import criteria
from bench.mismatch.orders.law_scores import (
    PRIOR_TURNS,
    Amplitudes,
    amplitudes,
    changes_of,
    factors,
    resonances,
    scores,
    stacked,
    tangent,
    unusual,
    whitened,
)
from bench.mismatch.orders.lowest import lowest
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.series import Series, calibrate
from bench.mismatch.orders.turns import Complex
from bench.mismatch.regression.scan import tail, tail_rate
from bench.simulation.frame import FloatArray
from bench.simulation.laws import RESONANCE, Law, factor, resonant, value

SURROGATES = 60


@dataclass(frozen=True, slots=True)
class FoundLaw:
    """A law, its p-value, standard deviations of its numbers (empty where they were chosen from a table) and of the
    strengths (orders,), the series calibrated under it; and the best law of each other effect with the log-likelihood
    that it gains less, the standard error of that over the orders, and its share among all.
    """

    law: Law
    p_value: float
    std: tuple[float, ...]
    strength_std: FloatArray
    series: Series
    rivals: tuple[tuple[Law, float, float, float], ...]
    share: float


def search(model: TransmissionModel, seed: int) -> FoundLaw | None:
    """The law that the amplitudes follow, if any gains more than the best of all does in noise."""
    data = amplitudes(model)
    if data is None:
        return None
    white, flat = whitened(data)
    points = [*resonances(data), *factors(data)]
    changes = changes_of(data, white, points)
    scored = [scores(p, c, flat[None]) for p, c in zip(points, changes, strict=True)]
    gains = np.array([float(own.total[0]) for own in scored])
    best = int(np.argmax(gains))
    drawn = np.random.default_rng([seed, 5]).normal(size=(SURROGATES, *flat.shape))
    nulls = np.max([scores(p, c, drawn).total for p, c in zip(points, changes, strict=True)], axis=0)
    if gains[best] < tail(nulls, criteria.ERROR_RATE_OF_A_CHANNEL):
        return None
    rate = tail_rate(nulls, float(gains[best]))
    by_effect: dict[str, int] = {}
    for k in np.argsort(-gains).tolist():
        by_effect.setdefault(points[k].effect, k)
    told = dict.fromkeys(by_effect, 0.0) | {e: float(gains[k]) for e, k in by_effect.items()}
    law, series = points[best], data.series
    std: tuple[float, ...] = ()
    strength_std = np.zeros(len(data.orders))
    # the grid is coarse for a resonance: it is refined before it is compared with what follows the speed anyhow
    if told.get(RESONANCE, -np.inf) > 0.5 * gains[best]:
        k = by_effect[RESONANCE]
        mode, mode_std, mode_series, gain = _refined_resonance(
            model, data, points[k], float(scored[k].participation[0])
        )
        told[RESONANCE] = max(told[RESONANCE], gain)
        if told[RESONANCE] >= gains[best]:
            law, std, series = mode, mode_std, mode_series
    if law.effect != RESONANCE:
        law, finer = _between_points(data, white, flat, law, gains[best])
        told[law.effect] = finer
        law, series, strength_std = _strengths(model, data, law)
    odds = {e: float(np.exp(min(g - told[law.effect], 0.0))) for e, g in told.items()}
    whole = sum(odds.values())
    mine = scored[by_effect[law.effect]].each[0]
    rivals = []
    for effect, k in by_effect.items():
        if effect != law.effect and np.isfinite(told[effect]):
            apart = mine - scored[k].each[0]
            error = float(np.std(apart) * np.sqrt(apart.size))
            rivals.append((points[k], told[law.effect] - told[effect], error, odds[effect] / whole))
    rivals.sort(key=lambda r: r[1])
    law = replace(law, gain=told[law.effect])
    return FoundLaw(law, rate, std, strength_std, series, tuple(rivals), 1.0 / whole)


def _between_points(
    data: Amplitudes, white: Sequence[FloatArray], flat: FloatArray, begin: Law, gain: float
) -> tuple[Law, float]:
    """A law of the form 1 + e*g between the points of its grid, where it gains most, and what it gains there."""
    if not begin.point:
        return begin, gain
    size = np.asarray(begin.point)

    def at(x: FloatArray) -> Law:
        return replace(begin, point=tuple(float(v) for v in size * np.exp(np.clip(x, -1.0, 1.0))))

    def loss(x: FloatArray) -> float:
        return -float(scores(at(x), changes_of(data, white, [at(x)])[0], flat[None]).total[0])

    found = lowest(loss, np.zeros(size.size), np.full(size.size, 0.05), 50)
    return (at(found), -loss(found)) if -loss(found) > gain else (begin, gain)


def _loss(data: Amplitudes, k: int, answer: Complex) -> float:
    """Negative log marginal likelihood of order k's vectors if they have passed ``answer`` (turns,)."""
    columns, centre = tangent(data, k)
    sigma = np.concatenate([data.sigma[:, k] / np.abs(answer)] * 2)
    lower = np.linalg.cholesky(columns @ columns.T + np.diag(sigma**2))
    z = solve_triangular(lower, stacked(data.vectors[:, k] / answer - centre), lower=True)
    squares = 0.5 * (z.size + 2.0 * PRIOR_TURNS) * np.log(float(z @ z) + 2.0 * PRIOR_TURNS)
    return float(squares + np.sum(np.log(np.diag(lower))) + 2.0 * np.sum(np.log(np.abs(answer))))


def _refined_resonance(
    model: TransmissionModel, data: Amplitudes, begin: Law, participation: float
) -> tuple[Law, tuple[float, ...], Series, float]:
    """Natural frequency, damping and participation by marginal likelihood, the series calibrated in turns with them."""
    point = np.log([begin.point[0], begin.point[1], max(participation, 0.01)])
    low, high = 0.3 * float(data.frequency.min()), 3.0 * float(data.frequency.max())

    def clipped(z: FloatArray) -> tuple[float, float, float]:
        w, damping, p = np.exp(z)
        return (
            float(np.clip(w, low, high)),
            float(np.clip(damping, 0.004, 0.8)),
            float(np.clip(p, 0.005, 1.5)),
        )

    def losses(own: tuple[float, float, float]) -> FloatArray:
        answer = resonant(data.frequency, own)
        return np.array([_loss(data, k, answer[:, k]) for k in range(len(data.orders))])

    touched = np.ones(len(data.orders), dtype=bool)
    series = data.series
    for _ in range(2):
        plain = losses((1e9, 0.5, 1.0))

        def total(z: FloatArray, plain: FloatArray = plain) -> float:
            own = clipped(z)
            return float(-np.sum(np.maximum(plain - losses(own), criteria.SPOILED))) + unusual(own[1])

        point = lowest(total, point, np.array([0.04, 0.3, 0.3]), 70)
        gain = plain - losses(clipped(point))
        touched = gain > criteria.SPOILED
        answer = np.where(touched[None, :], resonant(data.frequency, clipped(point)), 1.0)
        series = calibrate(model.own_turns, data.vectors / answer, data.sigma / np.abs(answer), data.orders)
        data = replace(data, series=series)
    own = clipped(point)
    std = _curvature(total, point)
    net = -total(point) - 1.5 * float(np.log(2.0 * len(data.time)))
    law = replace(begin, point=own, orders=tuple(f for f, t in zip(data.orders, touched, strict=True) if t))
    return law, tuple(s * v for s, v in zip(std, own, strict=True)), series, net


def _curvature(loss: Callable[[FloatArray], float], point: FloatArray) -> tuple[float, ...]:
    """Standard deviations of the logarithms of a resonance's numbers, from the likelihood's second differences."""
    n = point.size
    step = np.array([0.01, 0.1, 0.05])
    unit = np.diag(step)
    middle = loss(point)
    second = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            if i == j:
                second[i, i] = (loss(point + unit[i]) + loss(point - unit[i]) - 2.0 * middle) / step[i] ** 2
                continue
            cross = loss(point + unit[i] + unit[j]) + loss(point - unit[i] - unit[j])
            cross -= loss(point + unit[i] - unit[j]) + loss(point - unit[i] + unit[j])
            second[i, j] = second[j, i] = cross / (4.0 * step[i] * step[j])
    values, vectors = np.linalg.eigh(second)
    inverse = vectors @ np.diag(1.0 / np.maximum(values, 1e-3)) @ vectors.T
    return tuple(float(s) for s in np.sqrt(np.diag(inverse)))


def _strengths(model: TransmissionModel, data: Amplitudes, law: Law) -> tuple[Law, Series, FloatArray]:
    """Strength of a law of the form 1 + e*g in each order that takes part, the series calibrated in turns with it."""
    series = data.series
    g = value(law.effect, law.form, law.point, data.x, data.time, law.reference)
    strength = np.zeros(len(data.orders), dtype=np.complex128)
    std = np.zeros(len(data.orders))
    for _ in range(2):
        white, flat = whitened(data)
        smooth = data.series.vectors(data.x, data.direction)
        # two numbers an order, and any of the orders
        price = float(np.log(2.0 * len(g)) + np.log(len(data.orders)))
        for k, (lower, r) in enumerate(zip(white, flat, strict=True)):
            own = g * smooth[:, k]
            z = solve_triangular(lower, np.column_stack([stacked(own), stacked(1j * own)]), lower=True)
            right = z.T @ r
            inverse = np.linalg.inv(z.T @ z + 0.01 * np.eye(2))
            found = inverse @ right
            std[k] = float(np.sqrt(0.5 * np.trace(inverse)))
            strength[k] = found[0] + 1j * found[1] if 0.5 * float(right @ found) > price else 0.0
        law = replace(
            law,
            strength=strength.copy(),
            orders=tuple(f for f, e in zip(data.orders, strength, strict=True) if e != 0.0),
        )
        answer = factor(law, data.x, data.time, data.orders)
        series = calibrate(model.own_turns, data.vectors / answer, data.sigma / np.abs(answer), data.orders)
        data = replace(data, series=series)
    return law, series, std


def joined(whole: Series, own: Series) -> Series:
    """A series with some of its orders as another has them; both calibrated on the same revolutions."""
    place = [whole.orders.index(f) for f in own.orders]

    def rows(one: Mapping[int, FloatArray], other: Mapping[int, FloatArray]) -> dict[int, FloatArray]:
        out = {side: values.copy() for side, values in one.items()}
        for side, values in other.items():
            out[side][place] = values
        return out

    doubt, loss = whole.doubt.copy(), whole.loss.copy()
    doubt[:, place], loss[place] = own.doubt, own.loss
    return replace(
        whole,
        amplitude=rows(whole.amplitude, own.amplitude),
        phase=rows(whole.phase, own.phase),
        covariance=rows(whole.covariance, own.covariance),
        doubt=doubt,
        loss=loss,
    )
