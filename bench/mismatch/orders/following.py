"""Orders that have a part of their own which follows a quantity, or a state that is not recorded: a shaft that bows
while it warms, an eccentricity that sets in at some load.

Such a part is a vector of each order times a course, the same whatever else the order depends on; a law of the
amplitudes multiplies all of an order. The polynomials' coefficients are free beside it, as they are beside a law, so
nothing counts that a calibration could absorb. What the best of all courses gains in noise is measured on draws of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from bench.mismatch import criteria
from bench.mismatch.discovery import AMBIGUOUS, NAMED, UNKNOWN, UNNAMED, Discovery, RefittedAlternative
from bench.mismatch.orders.law_scores import RANK, Amplitudes, amplitudes, misfit, stacked, tangent
from bench.mismatch.orders.lowest import lowest
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.reported import probability, strong
from bench.mismatch.orders.revolutions import Complex, Revolution, passed
from bench.mismatch.regression.maxima import tail, tail_rate
from bench.mismatch.unnamed.formula_parts import Constant
from bench.mismatch.unnamed.formula_regressor import Equation
from bench.mismatch.unnamed.formula_units import product
from bench.simulation.formulas import Formula, evaluated
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.laws import MODES
from bench.simulation.quantities import (
    INPUT_ANGLE,
    OF_KIND,
    QUANTITIES,
    STATES,
    label,
    quantity,
    range_of,
    state_named,
    state_of,
)
from bench.simulation.terms import CHANNEL_UNITS, LIBRARY, TRANSMISSION_ERROR

KINDS = ("risen", "recent_loss", "recent_speed", "recent_load", "recent_load_size", "recent_torque")
"""kinds of states that the orders are asked to follow"""
EFFECTS = {"temperature": "te.temperature_nonlinear", "speed": "te.velocity_nonlinear", "time": "te.drift_time"}
"""effects that any function of a quantity in the amplitudes is: the report's contract"""
SURROGATES = 60
MOVED = 1.0
"""logarithm of the factor by which a number of a course is refined at most, either way: a table's next one"""
STEP, MOST = 0.1, 60
"""first step of such a logarithm, and evaluations"""
SPACING = 0.15
"""of a range, by which the places in it that are asked are apart"""
EDGE = 0.05
"""of a range, from its ends, where a place may be: at an end a knee is a straight line"""
WIDE = 3.0
"""times the spread that the orders have shown which the polynomials of one are given: what they could say by more than
that is no evidence of a course either
"""
RIDGE = 1e-9
"""keeps a course that the polynomials say wholly from breaking a solve"""


@dataclass(frozen=True, slots=True)
class Course:
    """A function of one quantity: its effect, the quantity or the kind of states, an expression of it (``x2``) with
    constants ``g1``, ``g2``, and their values; of a state, its scale. ``step``: how far ``g1`` is moved, where that is
    a place, 0 where it is none; ``within``: where it may be, or the scales that a state may have.
    """

    effect: str
    of: str
    text: str
    point: tuple[float, ...] = ()
    step: float = 0.0
    within: tuple[float, float] = (0.0, np.inf)

    @property
    def name(self) -> str:
        """The quantity, or the state with its scale."""
        return state_named(self.of, self.point[0]) if self.of in STATES else self.of

    @property
    def constants(self) -> tuple[tuple[str, float], ...]:
        """Symbols and values of the constants."""
        return () if self.of in STATES else tuple((f"g{k + 1}", v) for k, v in enumerate(self.point))

    def at(self, values: FloatArray) -> FloatArray:
        """The course at values of its quantity."""
        return np.asarray(evaluated(self.text, {"x2": values, **dict(self.constants)}), dtype=np.float64)

    def moved(self, logarithms: FloatArray) -> Course:
        """The same with other numbers, each times so much, a place moved by so many steps."""
        by = np.clip(logarithms, -MOVED, MOVED)
        point = np.asarray(self.point) * np.exp(by)
        if self.step:
            point[0] = self.point[0] + by[0] * self.step
        point[0] = np.clip(point[0], *self.within)
        return replace(self, point=tuple(float(v) for v in point))


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
    sight = _Sight.of(model)
    if sight is None:
        return None
    means = _Means(model.rows.frame, sight.revolutions)
    courses = [c for c in _courses(means, model.banned) if sight.beyond_polynomials(means(c))]
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
        RefittedAlternative(
            other.effect,
            _words(other, found.orders),
            loss,
            error,
            share,
            loss < max(error, criteria.RICHER),
            of_fitted=True,
        )
        for other, loss, error, share in found.alternatives
    )
    named = course.effect in LIBRARY
    as_good = [a for a in alternatives if a.as_good and a.effect in LIBRARY]
    own = 1.0 - sum(a.weight for a in alternatives)
    share = own + sum(a.weight for a in as_good) if named else own
    real = probability(found.p_value)
    return Discovery(
        effect=course.effect,
        status=(AMBIGUOUS if as_good else NAMED) if named else UNKNOWN,
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
        orders=found.orders,
        numbers=2 * len(found.orders) + len(course.point),
        excess=excess,
    )


def _words(course: Course, orders: Sequence[float]) -> str:
    if course.effect in LIBRARY:
        return LIBRARY[course.effect].name
    some = f"order{'s' if len(orders) > 1 else ''} {', '.join(f'{f:g}' for f in orders[:6])}"
    return f"{some} with the {label(course.name)}"


class _Means:
    """Courses over the revolutions: of a state its mean there, of what is recorded at the mean."""

    def __init__(self, frame: Frame, revolutions: Sequence[Revolution]) -> None:
        self.frame, self.revolutions = frame, revolutions
        self.known: dict[str, FloatArray] = {}

    def of(self, name: str) -> FloatArray:
        """Means of a quantity over the revolutions (revolutions,)."""
        if name not in self.known:
            values = quantity(name, self.frame)
            self.known[name] = np.array([values[t.rows].mean() for t in self.revolutions])
        return self.known[name]

    def __call__(self, course: Course) -> FloatArray:
        """A course (revolutions,)."""
        return course.at(self.of(course.name))


def _courses(means: _Means, banned: Sequence[str]) -> Iterator[Course]:
    """Courses that are asked: states slower than any revolution, and functions of what is recorded."""
    longest = max(t.duration for t in means.revolutions)
    for kind in KINDS:
        scales = (state[1] for name in OF_KIND[kind] if (state := state_of(name)) is not None)
        low, high = range_of(kind)
        within = (max(low, longest), high)
        yield from (Course(UNNAMED, kind, "x2", (scale,), within=within) for scale in scales if scale > longest)
    for name, shapes in _SHAPES.items():
        effect = EFFECTS.get(name, UNNAMED)
        if effect in banned:
            continue
        values = means.of(name)
        low, span = float(values.min()), float(np.ptp(values))
        for text, points in shapes:
            place = "x2 - g1" in text
            step, within = (SPACING * span if place else 0.0), (low + EDGE * span, low + (1.0 - EDGE) * span)
            within = within if place else (0.0, np.inf)
            yield from (Course(effect, name, text, point, step, within) for point in points(low, span))


def _places(low: float, span: float, widths: Sequence[float]) -> Iterator[tuple[float, ...]]:
    """Places over a range, each with some widths in parts of it."""
    for share in np.arange(0.1, 1.0, SPACING).tolist():
        yield from ((low + share * span, width * span) for width in widths)


def _knees(low: float, span: float) -> Iterator[tuple[float, ...]]:
    yield from ((low + share * span,) for share in np.arange(0.1, 1.0, SPACING).tolist())


Points = Callable[[float, float], Iterator[tuple[float, ...]]]
_TRANSITION: tuple[str, Points] = ("tanh((x2 - g1)/g2)", lambda low, span: _places(low, span, (0.05, 0.15)))
_BAND: tuple[str, Points] = ("exp(-((x2 - g1)/g2)**2)", lambda low, span: _places(low, span, (0.1, 0.25)))
_KNEE: tuple[str, Points] = ("abs(x2 - g1)", _knees)
_DECAY: tuple[str, Points] = (
    "exp(-x2/g1)",
    lambda low, span: iter([(share * (low + span),) for share in (0.1, 0.25, 0.6)]),
)
_SHAPES: Mapping[str, Sequence[tuple[str, Points]]] = {
    "temperature": (_TRANSITION, _BAND, _KNEE),
    "speed": (_DECAY, _BAND, _KNEE),
    "time": (("x2", lambda low, span: iter([()])), _TRANSITION, _KNEE),
    "torque": (_TRANSITION, _BAND, _KNEE),
}
"""expressions of what is recorded, with the points of each that are asked, by lowest value and range"""


def _refined(sight: _Sight, means: _Means, course: Course) -> Course:
    """A course with the numbers with which it gains most about those of the table."""
    if not course.point:
        return course
    begin = float(sight.gains(means(course)).sum())
    chosen = np.flatnonzero(sight.gains(means(course)) > 0.0).tolist()
    few = sight.less(chosen) if chosen else sight

    def loss(logarithms: FloatArray) -> float:
        return -float(few.gains(means(course.moved(logarithms))).sum())

    found = lowest(loss, np.zeros(len(course.point)), np.full(len(course.point), STEP), MOST)
    moved = course.moved(found)
    better = sight.beyond_polynomials(means(moved)) and float(sight.gains(means(moved)).sum()) > begin
    return moved if better else course


def _straight(data: Amplitudes) -> FloatArray:
    """Orthonormal basis (revolutions, k) of straight lines over the state in either direction, as far as revolutions
    tell them apart.
    """
    lines = np.column_stack([np.ones(len(data.x)), data.x])
    sides = [np.where((data.direction * side > 0)[:, None], lines, 0.0) for side in data.series.scaling]
    columns = np.hstack(sides)
    left, values, _ = np.linalg.svd(columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300), full_matrices=False)
    return np.asarray(left[:, values > RANK * values.max()])


def _whitened(data: Amplitudes, k: int) -> tuple[FloatArray, FloatArray]:
    """Cholesky factor (2*revolutions, 2*revolutions) of the covariance of an order's vectors, the polynomials' freedom
    in it; what is left of them, whitened (2*revolutions,).
    """
    columns, centre = tangent(data, k)
    sigma = np.concatenate([data.sigma[:, k]] * 2)
    lower = np.linalg.cholesky(WIDE**2 * columns @ columns.T + np.diag(sigma**2))
    left = solve_triangular(lower, stacked(data.vectors[:, k] - centre), lower=True)
    return np.asarray(lower), np.asarray(left)


@dataclass(frozen=True, slots=True)
class _Sight:
    """What the polynomials leave of ``orders`` of the series in the training ``revolutions``: ``left`` (orders,
    2*revolutions), whitened by Cholesky factors ``lowers`` of their freedom and the noise ``sigma`` (orders,
    2*revolutions), behind the ``response``
    (revolutions, orders) of modes. ``of_laws``: what other laws gain, without which all this is seen. An order pays for
    being chosen among ``many``. ``monomials``: of each direction its revolutions and the polynomials' basis there;
    ``straight`` (revolutions, k): orthonormal basis of straight lines over load, speed and temperature in either
    direction.
    """

    revolutions: tuple[Revolution, ...]
    orders: tuple[float, ...]
    left: FloatArray
    lowers: tuple[FloatArray, ...]
    sigma: FloatArray
    response: Complex
    of_laws: float
    many: int
    monomials: tuple[tuple[NDArray[np.bool_], FloatArray], ...]
    straight: FloatArray

    @classmethod
    def of(cls, model: TransmissionModel) -> _Sight | None:
        """The orders of a model into which no others leak; None where there are none, or too few revolutions."""
        if model.periodic is None:
            return None
        given = {id(law) for law in model.given.laws}
        kept = tuple(law for law in model.periodic.laws if id(law) in given or law.form in MODES)
        data = amplitudes(replace(model, periodic=replace(model.periodic, laws=kept)))
        if data is None or not data.regular.any():
            return None
        chosen = np.flatnonzero(data.regular)
        seen = [_whitened(data, int(k)) for k in chosen]
        sides = [(data.direction * side > 0, scaling) for side, scaling in data.series.scaling.items()]
        held = {id(law) for law in kept}
        return cls(
            tuple(model.training_revolutions),
            tuple(data.orders[k] for k in chosen),
            np.array([left for _, left in seen]),
            tuple(lower for lower, _ in seen),
            np.vstack([data.sigma[:, chosen]] * 2).T,
            passed(kept, model.training_revolutions, data.orders)[:, chosen],
            sum(law.gain for law in model.periodic.laws if id(law) not in held),
            chosen.size,
            tuple((rows, scaling.monomials(data.x[rows])) for rows, scaling in sides if rows.any()),
            _straight(data),
        )

    def beyond_polynomials(self, course: FloatArray) -> bool:
        """Whether a ``course`` (revolutions,) varies in a way that no polynomial of the series can say, but for a share
        of it.
        """
        left = whole = 0.0
        for rows, basis in self.monomials:
            values = course[rows]
            left += float(np.sum((values - basis @ np.linalg.lstsq(basis, values, rcond=RANK)[0]) ** 2))
            whole += float(np.sum((values - values.mean()) ** 2))
        return whole > RANK**2 * float(np.sum(course**2)) and left > criteria.LAW_BEYOND * whole

    def less(self, chosen: Sequence[int]) -> _Sight:
        """The same with some of the orders."""
        return replace(
            self,
            orders=tuple(self.orders[k] for k in chosen),
            left=self.left[chosen],
            lowers=tuple(self.lowers[k] for k in chosen),
            sigma=self.sigma[chosen],
            response=self.response[:, chosen],
        )

    def scored(self, courses: FloatArray, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        """Gain (courses, orders) of each of some ``courses`` (courses, revolutions), and what the best of them gains in
        draws of noise as large as what is left, or as it should be (SURROGATES,).
        """
        seen, drawn = [], np.zeros((len(courses), SURROGATES))
        for k in range(len(self.orders)):
            noise = self._drawn(k, rng)
            gains = self._gains(self._columns(k, courses), np.vstack([self.left[k], noise]))
            seen.append(gains[:, 0])
            drawn += gains[:, 1:]
        return np.array(seen).T, drawn.max(axis=0)

    def _drawn(self, k: int, rng: np.random.Generator) -> FloatArray:
        """Draws (SURROGATES, 2*revolutions) of what an order has if it follows nothing: what the polynomials leave of
        its vectors, over their noise, in other revolutions and with signs of their own, as large as it is seen, or as
        it should be. What the polynomials take of it is missing in the draws as well.
        """
        lower, sigma, number = self.lowers[k], self.sigma[k], len(self.revolutions)
        shaped = solve_triangular(lower, np.diag(sigma), lower=True)
        usual = max(float(np.sum(self.left[k] ** 2) / np.sum(shaped**2)), 1.0)
        over = sigma * solve_triangular(lower, self.left[k], lower=True, trans=1)
        over *= np.sqrt(usual / max(float(np.mean(over**2)), 1e-300))
        draws = np.empty((SURROGATES, 2 * number))
        for row in draws:
            at, sign = rng.permutation(number), rng.choice([-1.0, 1.0], number)
            row[:] = np.concatenate([over[at] * sign, over[number + at] * sign])
        return np.asarray(draws @ shaped.T)

    def gains(self, course: FloatArray) -> FloatArray:
        """Gain of log-likelihood (orders,) by a ``course`` (revolutions,), 0 where it does not pay for its numbers."""
        parts = ((self._columns(k, course[None]), self.left[k][None]) for k in range(len(self.orders)))
        return np.array([float(self._gains(z, left)[0, 0]) for z, left in parts])

    def estimated(self, course: FloatArray) -> tuple[tuple[float, ...], Complex, FloatArray]:
        """Orders that gain by a ``course`` (revolutions,), their vectors, the standard deviation of a component."""
        orders, vectors, std = [], [], []
        for k in np.flatnonzero(self.gains(course) > 0.0).tolist():
            z, r = self._columns(k, course[None])[0], self.left[k]
            inverse = np.linalg.inv(z.T @ z)
            found = inverse @ (z.T @ r)
            noise = max(float(np.mean((r - z @ found) ** 2)), 1.0)
            orders.append(self.orders[k])
            vectors.append(complex(found[0], found[1]))
            std.append(float(np.sqrt(0.5 * noise * np.trace(inverse))))
        return tuple(orders), np.array(vectors), np.array(std)

    def _columns(self, k: int, courses: FloatArray) -> FloatArray:
        """What a vector times each course does to an order, whitened (courses, 2*revolutions, 2)."""
        # straight lines over the state are the polynomials', however large: only what is beyond them counts
        curved = courses - courses @ self.straight @ self.straight.T
        moved = (curved / self.response[:, k]).T
        whole = np.hstack([stacked(moved), stacked(1j * moved)])
        white = solve_triangular(self.lowers[k], whole, lower=True)
        return np.stack([white[:, : len(courses)].T, white[:, len(courses) :].T], axis=2)

    def _gains(self, columns: FloatArray, left: FloatArray) -> FloatArray:
        """Gain (courses, draws) of an order by whitened ``columns`` (courses, 2*revolutions, 2), fitted to each of some
        draws of what is ``left`` (draws, 2*revolutions).
        """
        number = len(self.revolutions)
        product_of = np.swapaxes(columns, 1, 2) @ left.T
        gram = np.swapaxes(columns, 1, 2) @ columns
        size = np.trace(gram, axis1=1, axis2=2)[:, None, None]
        solved = np.linalg.solve(gram + (RIDGE * size + 1e-300) * np.eye(2), product_of)
        before = np.sum(left**2, axis=1)[None, :]
        after = np.maximum(before - np.sum(product_of * solved, axis=1), 0.0)
        # two numbers an order (BIC), and any of the orders
        price = float(np.log(2.0 * number) + np.log(self.many))
        return np.asarray(np.maximum(misfit(before, number) - misfit(after, number) - price, 0.0))
