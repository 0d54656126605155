"""Laws that the amplitudes of the known orders follow beyond the paper's quadratic polynomials.

A law multiplies an order's vector: a resonance by 1 + p*G(f*v), every other by 1 + e*g with g of speed,
temperature, time or load and e of each order. The polynomials' coefficients are free beside it, with the spread that
the orders themselves have shown (their tangent is part of the noise), so nothing counts that a calibration could
absorb. What the best of all laws gains in noise is measured on draws of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from bench.mismatch import criteria
from bench.mismatch.orders import modes
from bench.mismatch.orders.calibrating import calibrated_by
from bench.mismatch.orders.law_scores import (
    Amplitudes,
    amplitudes,
    changes_of,
    course,
    factors,
    misfit,
    resonances,
    scores,
    stacked,
    whitened,
)
from bench.mismatch.orders.lowest import lowest
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.revolutions import states_of
from bench.mismatch.orders.series import Series
from bench.mismatch.regression.maxima import tail, tail_rate
from bench.simulation.frame import FloatArray
from bench.simulation.laws import RESONANCE, Law, factor

SURROGATES = 60
SECOND_LOOK = 0.5 * criteria.ERROR_RATE_OF_A_CHANNEL
"""rate at which noise may pass the look that is taken where the first saw nothing"""
FEWEST_MOVED = 2
"""orders that a mode moves each by a strength of its own: what one alone follows is a function of the speed"""
FEWEST_STATES = 3
"""speeds (loads) from which a law of them is asked for: through two goes every law"""


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
    alternatives: tuple[tuple[Law, float, float, float], ...]
    share: float


def search(model: TransmissionModel, seed: int) -> FoundLaw | None:
    """The law that the amplitudes follow, if any gains more than the best of all does in noise."""
    data = amplitudes(model)
    if data is None:
        return None
    white, flat = whitened(data)
    others = factors(data)
    points = [p for p in (*resonances(data), *others) if _driven(data, p.variables[0])]
    if not points:
        return None
    changes = changes_of(data, white, points)
    scored = [scores(p, c, flat[None]) for p, c in zip(points, changes, strict=True)]
    gains = np.array([float(score.total[0]) for score in scored])
    best = int(np.argmax(gains))
    drawn = np.random.default_rng([seed, 5]).normal(size=(SURROGATES, *flat.shape))
    nulls = np.max([scores(p, c, drawn).total for p, c in zip(points, changes, strict=True)], axis=0)
    resounding = model.periodic is not None and any(law.effect == RESONANCE for law in model.periodic.laws)
    moved: modes.Moved | None = None
    if gains[best] >= tail(nulls, criteria.ERROR_RATE_OF_A_CHANNEL):
        rate = tail_rate(nulls, float(gains[best]))
    else:
        # a strong mode spoils the series that the scan begins at
        asked = not resounding and any(p.effect == RESONANCE for p in points)
        beyond = modes.beyond_noise(data, others, seed, SURROGATES, SECOND_LOOK) if asked else None
        if beyond is None:
            return None
        moved, rate = beyond
    second = moved is not None
    by_effect: dict[str, int] = {}
    for k in np.argsort(-gains).tolist():
        by_effect.setdefault(points[k].effect, k)
    gain_of = dict.fromkeys(by_effect, 0.0) | {e: float(gains[k]) for e, k in by_effect.items()}
    each = {e: scored[k].each[0] for e, k in by_effect.items()}
    mode = swung = None
    # the scan's tangent is that of a weak mode: the vectors are asked themselves, and the mode refined, before it is
    # compared with what follows the speed anyhow
    if RESONANCE in gain_of:
        begin, gain = modes.begun(data)
        if max(gain_of[RESONANCE], gain) > 0.5 * gains[best]:
            mode = modes.refined(model, data, begin)
            gain_of[RESONANCE], each[RESONANCE] = mode.gain, mode.each
        # beside a mode that was found, what its numbers leave is none with strengths as they please
        if moved is None and not resounding:
            moved = modes.of_each(data)
        if moved is not None and moved.gain > criteria.RICHER:
            swung = _rather_than(mode, max(gain, gain_of[RESONANCE]), moved, model, data)
            if swung is not None and moved.gain > gain_of[RESONANCE]:
                gain_of[RESONANCE], each[RESONANCE] = moved.gain, moved.each
    effect = max(gain_of, key=lambda e: gain_of[e])
    if second and (swung is None or effect != RESONANCE):
        return None  # what has passed is the mode that each order moves, and nothing else
    std: tuple[float, ...] = ()
    if swung is not None and effect == RESONANCE:
        law, series, strength_std = swung
    elif mode is not None and effect == RESONANCE:
        law, std, series, strength_std = mode.law, mode.std, mode.series, np.zeros(len(data.orders))
    else:
        law, gain_of[effect] = _between_points(data, white, flat, points[by_effect[effect]], gain_of[effect])
        law, series, strength_std = _strengths(model, data, law)
    odds = {e: float(np.exp(min(g - gain_of[effect], 0.0))) for e, g in gain_of.items()}
    whole = sum(odds.values())
    alternatives = []
    for other, k in by_effect.items():
        if other != effect and np.isfinite(gain_of[other]):
            apart = each[effect] - each[other]
            error = float(np.std(apart) * np.sqrt(apart.size))
            alternatives.append((points[k], gain_of[effect] - gain_of[other], error, odds[other] / whole))
    alternatives.sort(key=lambda r: r[1])
    law = replace(law, gain=gain_of[effect])
    return FoundLaw(law, rate, std, strength_std, series, tuple(alternatives), 1.0 / whole)


def _swung(model: TransmissionModel, data: Amplitudes, moved: modes.Moved) -> tuple[Law, Series, FloatArray] | None:
    """A mode that each order moves with a strength of its own, the series calibrated under it, and how uncertain the
    strengths are; None where fewer orders than :data:`FEWEST_MOVED` take part.
    """
    series = calibrated_under(model, data, moved.law)
    law, series, std = _strengths(model, replace(data, series=series), moved.law)
    return (law, series, std) if len(law.orders) >= FEWEST_MOVED else None


def _rather_than(
    mode: modes.Mode | None, gain: float, moved: modes.Moved, model: TransmissionModel, data: Amplitudes
) -> tuple[Law, Series, FloatArray] | None:
    """What :func:`_swung` says of a mode that each order moves, where it gains more than the ``gain`` of a ``mode`` of
    one participation, or leaves less; else None.
    """
    better = moved.gain > gain + criteria.RICHER
    if not better and mode is None:
        return None
    swung = _swung(model, data, moved)
    return swung if swung is None or better or _leaves_less(data, swung, mode) else None


def _leaves_less(data: Amplitudes, swung: tuple[Law, Series, FloatArray], mode: modes.Mode | None) -> bool:
    """Whether strengths of each order leave less of the vectors than one participation of all, by more than their
    numbers cost (BIC), each beside a series calibrated under it. Before that is calibrated one participation says more
    than it holds: it turns the polynomials with it.
    """
    if mode is None:
        return False
    law, series, _ = swung
    revolutions, beyond = len(data.time), 2 * len(law.orders) - 1
    gained = _misfit(data, mode.law, mode.series) - _misfit(data, law, series)
    return gained - 0.5 * beyond * float(np.log(2.0 * revolutions)) > criteria.RICHER


def _misfit(data: Amplitudes, law: Law, series: Series) -> float:
    """Negative log-likelihood of the vectors if they are a calibrated series under a law, noise of any size."""
    said = series.vectors(data.x, data.direction) * factor(law, data.x, data.time, data.orders)
    return float(np.sum(misfit(np.sum(np.abs((data.vectors - said) / data.sigma) ** 2, axis=0), len(data.time))))


def _driven(data: Amplitudes, quantity: str) -> bool:
    """Whether the revolutions have so many speeds (loads) that a law of them can be told; other quantities vary as they
    will.
    """
    values = {"speed": np.abs(data.x[:, 1]), "torque": data.x[:, 0]}.get(quantity)
    if values is None:
        return True
    return states_of(values, criteria.WAVERING * float(np.abs(values).max())) >= FEWEST_STATES


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


def _strengths(model: TransmissionModel, data: Amplitudes, law: Law) -> tuple[Law, Series, FloatArray]:
    """Strength of a law of the form 1 + e*g in each order that takes part, the series calibrated in turns with it."""
    series = data.series
    g = course(law, data)
    strength = np.zeros(len(data.orders), dtype=np.complex128)
    std = np.zeros(len(data.orders))
    regular = data.regular
    for _ in range(2):
        white, flat = whitened(data)
        smooth = data.series.vectors(data.x, data.direction)
        # two numbers an order, and any of the orders
        price = float(np.log(2.0 * len(g)) + np.log(len(data.orders)))
        for k, (lower, r) in enumerate(zip(white, flat, strict=True)):
            changed = g[:, k] * smooth[:, k]
            z = solve_triangular(lower, np.column_stack([stacked(changed), stacked(1j * changed)]), lower=True)
            right = z.T @ r
            inverse = np.linalg.inv(z.T @ z + 0.01 * np.eye(2))
            found = inverse @ right
            std[k] = float(np.sqrt(0.5 * np.trace(inverse)))
            strong = regular[k] and 0.5 * float(right @ found) > price
            strength[k] = found[0] + 1j * found[1] if strong else 0.0
        law = replace(
            law,
            strength=strength.copy(),
            orders=tuple(f for f, e in zip(data.orders, strength, strict=True) if e != 0.0),
        )
        series = calibrated_under(model, data, law)
        data = replace(data, series=series)
    return law, series, std


def calibrated_under(model: TransmissionModel, data: Amplitudes, law: Law) -> Series:
    """The series calibrated under a law."""
    return calibrated_by(model, data.vectors, data.sigma, data.orders, factor(law, data.x, data.time, data.orders))


def joined(whole: Series, part: Series) -> Series:
    """A series with some of its orders as another has them; both calibrated on the same revolutions."""
    columns = [whole.orders.index(f) for f in part.orders]

    def rows(one: Mapping[int, FloatArray], other: Mapping[int, FloatArray]) -> dict[int, FloatArray]:
        out = {side: values.copy() for side, values in one.items()}
        for side, values in other.items():
            out[side][columns] = values
        return out

    prior, doubt, loss = whole.prior.copy(), whole.doubt.copy(), whole.loss.copy()
    prior[columns], doubt[:, columns], loss[columns] = part.prior, part.doubt, part.loss
    return replace(
        whole,
        amplitude=rows(whole.amplitude, part.amplitude),
        phase=rows(whole.phase, part.phase),
        covariance=rows(whole.covariance, part.covariance),
        prior=prior,
        doubt=doubt,
        loss=loss,
    )
