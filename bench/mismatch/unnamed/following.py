"""Orders that have a part of their own which follows a quantity, or a state that is not recorded: a shaft that bows
while it warms, an eccentricity that sets in at some load.

Such a part is a vector of each order times a course, the same whatever else the order depends on; a law of the
amplitudes multiplies all of an order. The polynomials' coefficients are free beside it, wider than beside a law, and
straight lines over the state altogether, so nothing counts that a calibration could absorb. What the best of all
courses gains where orders follow nothing is measured on draws of that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import Discovery, RefittedAlternative
from bench.mismatch.orders.beside_polynomials import Sight
from bench.mismatch.orders.courses import Course, Means, courses_over
from bench.mismatch.orders.lowest import lowest
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.reported import probability, strong
from bench.mismatch.orders.reported_law import status_of
from bench.mismatch.orders.revolutions import Complex
from bench.mismatch.regression.maxima import tail, tail_rate
from bench.mismatch.regression.windows import strongest
from bench.mismatch.unnamed.formula_parts import Constant
from bench.mismatch.unnamed.formula_regressor import Equation
from bench.mismatch.unnamed.formula_units import product
from bench.simulation.formulas import Formula
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import INPUT_ANGLE, QUANTITIES, label, quantity
from bench.simulation.terms import CHANNEL_UNITS, LIBRARY, TRANSMISSION_ERROR

STEP, MOST = 0.1, 60
"""first step of a logarithm in which a course's number is refined, and evaluations"""


@dataclass(frozen=True, slots=True)
class Following:
    """Orders that follow a ``course``: their vectors b + j*a (orders,), rad, with the standard deviation of a component
    (orders,); gain of log-likelihood, p-value; the best course of each other effect with what it gains less, the
    standard error of that over the orders, and its share among all.
    """

    course: Course
    orders: tuple[float, ...]
    vectors: Complex
    std: FloatArray
    gain: float
    p_value: float
    alternatives: tuple[tuple[Course, float, float, float], ...] = ()

    @property
    def coefficients(self) -> FloatArray:
        """Of cosine and sine of each order in turn."""
        return np.column_stack([self.vectors.imag, self.vectors.real]).ravel()

    def equation(self, frame: Frame) -> Equation:
        """A formula of angle and quantity, the latter within what the rows of ``frame`` have of it."""
        course, values = self.course, quantity(self.course.name, frame)
        angles = ("x1" if f == 1.0 else f"{f:g}*x1" for f in self.orders)
        text = course.text if course.text.isidentifier() else f"({course.text})"
        parts = tuple(("1", f"{text}*{wave}({angle})") for angle in angles for wave in ("cos", "sin"))
        within = ((0.0, 2.0 * np.pi), (float(values.min()), float(values.max())))
        unit = QUANTITIES[course.name].unit
        per = unit if course.text == "x2" else "1"
        # the first is a place on the quantity's scale, but for a decay; widths are differences
        scales = [unit if course.step and k == 0 else product([(unit, 1)]) for k in range(len(course.constants))]
        constants = tuple(Constant(s, v, of) for (s, v), of in zip(course.constants, scales, strict=True))
        units = (product([(CHANNEL_UNITS[TRANSMISSION_ERROR], 1), (per, -1)]),) * len(parts)
        formula = Formula((INPUT_ANGLE, course.name), within, parts, course.constants)
        return Equation(TRANSMISSION_ERROR, formula, units, constants, course.effect)

    def evaluate(self, frame: Frame) -> FloatArray:
        """What the orders have of it at the rows of a frame (n,), rad."""
        return np.asarray(self.equation(frame).columns(frame) @ self.coefficients)


def search(model: TransmissionModel, seed: int) -> Following | None:
    """The course that orders follow, if any gains more than the best of all does in noise, and than the laws of the
    amplitudes do that were found without it.
    """
    sight = Sight.of(model)
    if sight is None:
        return None
    means = Means(model.rows.frame, sight.revolutions)
    courses = [c for c in courses_over(means, model.banned) if sight.beyond_polynomials(means(c))]
    if not courses:
        return None
    rng = np.random.default_rng([seed, 11])
    seen, nulls = sight.scored(np.array([means(c) for c in courses]), rng)
    total = seen.sum(axis=1)
    best = int(np.argmax(total))
    least = max(tail(nulls, criteria.ERROR_RATE_OF_A_CHANNEL), sight.of_laws + criteria.RICHER)
    if total[best] < least:
        return None
    by_effect: dict[str, int] = {}
    for k in np.argsort(-total).tolist():
        by_effect.setdefault(courses[k].effect, k)
    refined = [_refined(sight, means, courses[k]) for k in by_effect.values() if total[k] > 0.0]
    each = [sight.gains(means(course)) for course in refined]
    order = np.argsort([-float(gains.sum()) for gains in each])
    first = int(order[0])
    course, gain = refined[first], float(each[first].sum())
    share = np.exp(np.array([float(g.sum()) for g in each]) - gain)
    alternatives = []
    for k in order[1:].tolist():
        apart = each[first] - each[k]
        error = float(np.std(apart) * np.sqrt(apart.size))
        alternatives.append((refined[k], float(apart.sum()), error, float(share[k] / share.sum())))
    orders, vectors, std = sight.estimated(means(course))
    return Following(course, orders, vectors, std, gain, tail_rate(nulls, float(total[best])), tuple(alternatives))


def as_discovery(model: TransmissionModel, found: Following, excess: FloatArray) -> Discovery | None:
    """Orders that follow a course as a discovery; ``excess`` (n,): what no calibration says of them. None where they
    are weak.
    """
    equation, coefficients = found.equation(model.rows.frame), found.coefficients
    added, std = found.evaluate(model.rows.frame), np.repeat(found.std, 2)
    if not strong(model, excess):
        return None
    course = found.course
    alternatives = tuple(
        RefittedAlternative.of_revolutions(other.effect, _words(other, found.orders), loss, error, share)
        for other, loss, error, share in found.alternatives
    )
    status, share = status_of(course.effect, 1.0 - sum(a.weight for a in alternatives), alternatives)
    real = probability(found.p_value)
    return Discovery(
        effect=course.effect,
        status=status,
        confidence=None if real is None else real * share,
        channel=TRANSMISSION_ERROR,
        words=_words(course, found.orders),
        equation=equation.equation,
        variables=(course.name,),
        parameters=tuple(equation.parameters(coefficients, std)),
        added=added,
        gain=found.gain,
        p_value=found.p_value,
        simulation_rows=({"effect": course.effect} | equation.row(coefficients, std),),
        alternatives=alternatives,
        orders=tuple(found.orders[k] for k in strongest(np.abs(found.vectors) ** 2)),
        numbers=2 * len(found.orders) + len(course.point),
        excess=excess,
    )


def _words(course: Course, orders: Sequence[float]) -> str:
    if course.effect in LIBRARY:
        return LIBRARY[course.effect].name
    some = f"order{'s' if len(orders) > 1 else ''} {', '.join(f'{f:g}' for f in orders[:6])}"
    return f"{some} with the {label(course.name)}"


def _refined(sight: Sight, means: Means, course: Course) -> Course:
    """A course with the numbers with which it gains most about those of the table."""
    if not course.point:
        return course
    begun = sight.gains(means(course))
    chosen = np.flatnonzero(begun > 0.0).tolist()
    few = sight.less(chosen) if chosen else sight

    def loss(logarithms: FloatArray) -> float:
        return -float(few.gains(means(course.moved(logarithms))).sum())

    found = lowest(loss, np.zeros(len(course.point)), np.full(len(course.point), STEP), MOST)
    moved = course.moved(found)
    better = sight.beyond_polynomials(means(moved)) and float(sight.gains(means(moved)).sum()) > float(begun.sum())
    return moved if better else course
