"""A resonance that the orders pass, by the marginal likelihood of their vectors under its response.

A weak mode changes the vectors in proportion to its participation, and a scan of the law's tangent finds it
(:mod:`bench.mismatch.orders.law_scores`). A strong one has spoiled the series that the tangent is taken at. So the
vectors are divided by the response of each mode that is tried, and asked whether polynomials say what is left; the
best is refined, the series calibrated in turns with it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from bench.mismatch import criteria
from bench.mismatch.orders.calibrating import calibrated_by
from bench.mismatch.orders.law_scores import (
    PRIOR_REVOLUTIONS,
    Amplitudes,
    course,
    misfit,
    resonances,
    stacked,
    tangent,
    unusual,
)
from bench.mismatch.orders.lowest import lowest
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.revolutions import Complex
from bench.mismatch.orders.series import FIRST_PRIOR, Series
from bench.mismatch.regression.maxima import tail, tail_rate
from bench.simulation.frame import FloatArray
from bench.simulation.laws import EACH, RESONANCE, Law, resonant

PARTICIPATIONS = (0.08, 0.25, 0.75)
"""that are tried of each mode"""
STEPS = np.array([0.04, 0.3, 0.3])
"""of the logarithms of natural frequency, damping and participation, with which they are refined"""
EVALUATIONS = 70
DAMPED = (0.004, 0.8)
"""damping ratios between which a mode is sought"""
SWINGS = 3.0
"""time constants of a mode in a revolution at the usual speed: a twentieth of its swing is left after three"""
_FREE = 10.0
"""spread of an order's mean vector, in units of its size"""
_SPREAD = np.append(np.sqrt(0.5 * (1.0 + 1.5**2)) * FIRST_PRIOR, _FREE)
"""prior spread of each monomial's coefficient in an order's vectors, in units of their usual size"""
_NOTHING = (1e9, 0.5, 1.0)
"""a mode that no order comes near"""


@dataclass(frozen=True, slots=True)
class Mode:
    """A resonance as a law, standard deviations of its numbers, the series calibrated under it, the log-likelihood it
    gains less its numbers' price, and what ``each`` order gains of it (orders,).
    """

    law: Law
    std: tuple[float, ...]
    series: Series
    gain: float
    each: FloatArray


def begun(data: Amplitudes) -> tuple[Law, float]:
    """The mode under which the vectors are most of all polynomials of the state, strong or weak, and the log-likelihood
    it gains.
    """
    plain = _smoothness(data, np.ones_like(data.vectors))
    clipped = Bounds.of(data).clipped

    def gain(form: str, point: Sequence[float]) -> float:
        left = _smoothness(data, resonant(form, data.frequency, tuple(point)))
        return float(np.sum(np.maximum(left - plain, criteria.SPOILED))) - unusual(point[1])

    def polished(law: Law) -> tuple[Law, float]:
        """The law between the points of the grid."""
        found = lowest(lambda z: -gain(law.form, clipped(z)), np.log(law.point), STEPS, EVALUATIONS)
        point = clipped(found)
        return replace(law, point=point), gain(law.form, point)

    out: dict[str, tuple[Law, float]] = {}
    # a strong mode has hills beside it: from the best of each participation
    for participation in PARTICIPATIONS:
        best: dict[str, tuple[Law, float]] = {}
        for law in resonances(data):
            varied = replace(law, point=(*law.point[:2], participation))
            gained = gain(varied.form, varied.point)
            if varied.form not in best or gained > best[varied.form][1]:
                best[varied.form] = varied, gained
        for form, (law, _) in best.items():
            finer = polished(law)
            if form not in out or finer[1] > out[form][1]:
                out[form] = finer
    return max(out.values(), key=lambda varied: varied[1])


@dataclass(frozen=True, slots=True)
class Bounds:
    """Natural frequencies in rad/s between which a mode is sought, and the slowest ``decay`` (1/s) of its swings."""

    low: float
    high: float
    decay: float

    @classmethod
    def of(cls, data: Amplitudes) -> Bounds:
        """From what the orders pass to three times beyond; a mode that every order has passed long ago is none. What it
        swings by has died away within a revolution: else no revolution is steady, and its law says nothing of any.
        """
        passed, speed = np.abs(data.frequency), float(np.median(np.abs(data.x[:, 1])))
        decay = SWINGS * speed / (2.0 * np.pi)
        high = 3.0 * float(passed.max())
        return cls(min(max(float(passed.min()), decay / DAMPED[1]), high), high, decay)

    def clipped(self, logarithms: FloatArray) -> tuple[float, float, float]:
        """Natural frequency, damping and participation from their logarithms."""
        w, damping, p = np.exp(logarithms)
        w = float(np.clip(w, self.low, self.high))
        least = min(max(DAMPED[0], self.decay / w), DAMPED[1])
        return w, float(np.clip(damping, least, DAMPED[1])), float(np.clip(p, 0.005, 1.5))


def _smoothness(data: Amplitudes, answer: Complex) -> FloatArray:
    """Log marginal likelihood (orders,) of the vectors if they are polynomials that have passed ``answer``
    (revolutions, orders), each direction with its own.
    """
    size = np.abs(answer)
    before = data.vectors / answer
    out = -2.0 * np.sum(np.log(size), axis=0)
    for side, scaling in data.series.scaling.items():
        on_side = data.direction * side > 0
        basis = scaling.monomials(data.x[on_side]) * _SPREAD
        level = np.median(np.abs(before[on_side]), axis=0)
        noise = (data.sigma[on_side] / size[on_side]) ** 2
        covariance = (level**2)[:, None, None] * (basis @ basis.T)[None]
        covariance[:, np.arange(len(basis)), np.arange(len(basis))] += noise.T
        lower = np.linalg.cholesky(covariance)
        z = np.linalg.solve(lower, before[on_side].T[:, :, None])[:, :, 0]
        out -= misfit(np.sum(np.abs(z) ** 2, axis=1), len(basis))
        out -= 2.0 * np.sum(np.log(np.diagonal(lower, axis1=1, axis2=2)), axis=1)
    return np.asarray(out)


@dataclass(frozen=True, slots=True)
class _Freedom:
    """By what an order's polynomials may move its vectors: covariance (2*revolutions, 2*revolutions) and ``centre``
    (revolutions,).
    """

    covariance: FloatArray
    centre: Complex

    @classmethod
    def of(cls, data: Amplitudes) -> list[_Freedom]:
        """That of each order about its series."""
        out = []
        for k in range(len(data.orders)):
            columns, centre = tangent(data, k)
            out.append(cls(columns @ columns.T, centre))
        return out

    def loss(self, vectors: Complex, sigma: FloatArray, answer: Complex) -> float:
        """Negative log marginal likelihood of the order's ``vectors`` if they have passed ``answer`` (revolutions,)."""
        variance = np.concatenate([sigma / np.abs(answer)] * 2) ** 2
        lower = np.linalg.cholesky(self.covariance + np.diag(variance))
        z = solve_triangular(lower, stacked(vectors / answer - self.centre), lower=True)
        squares = float(misfit(z @ z, 0.5 * z.size))
        return float(squares + np.sum(np.log(np.diag(lower))) + 2.0 * np.sum(np.log(np.abs(answer))))


def _losses(data: Amplitudes, freedom: Sequence[_Freedom], form: str, point: Sequence[float]) -> FloatArray:
    answer = resonant(form, data.frequency, tuple(point))
    return np.array([f.loss(data.vectors[:, k], data.sigma[:, k], answer[:, k]) for k, f in enumerate(freedom)])


def refined(
    model: TransmissionModel, data: Amplitudes, begin: Law, beside: Callable[[Law], float] = lambda _: 0.0
) -> Mode:
    """Natural frequency, damping and participation by marginal likelihood, the series calibrated in turns with them.

    ``beside``: log-likelihood that orders beside the series gain under a mode.
    """
    point = np.log(begin.point)
    clipped = Bounds.of(data).clipped

    def under(point: FloatArray, touched: NDArray[np.bool_]) -> Amplitudes:
        answer = np.where(touched[None, :], resonant(begin.form, data.frequency, clipped(point)), 1.0)
        return replace(data, series=calibrated_by(model, data.vectors, data.sigma, data.orders, answer))

    plain = _losses(data, _Freedom.of(data), begin.form, _NOTHING)
    touched = np.ones(len(data.orders), dtype=bool)
    now = under(point, touched)
    for _ in range(2):
        freedom = _Freedom.of(now)

        def total(z: FloatArray, freedom: list[_Freedom] = freedom) -> float:
            at = clipped(z)
            gains = plain - _losses(data, freedom, begin.form, at)
            more = beside(replace(begin, point=at))
            return float(-np.sum(np.maximum(gains, criteria.SPOILED))) + unusual(at[1]) - more

        point = lowest(total, point, STEPS, EVALUATIONS)
        each = plain - _losses(data, freedom, begin.form, clipped(point))
        touched = each > criteria.SPOILED
        now = under(point, touched)
    at = clipped(point)
    net = -total(point) - 1.5 * float(np.log(2.0 * len(data.time)))
    orders = tuple(f for f, t in zip(data.orders, touched, strict=True) if t)
    law = replace(begin, point=at, orders=orders)
    std = tuple(s * v for s, v in zip(_curvature(total, point), at, strict=True))
    return Mode(law, std, now.series, net, np.maximum(each, criteria.SPOILED))


@dataclass(frozen=True, slots=True)
class Moved:
    """A mode that each order moves with a strength of its own, as a law; the log-likelihood it gains, and what ``each``
    order gains of it (orders,).
    """

    law: Law
    gain: float
    each: FloatArray


@dataclass(frozen=True, slots=True)
class Swinging:
    """What modes gain that each order moves as it will, beside polynomials of the state.

    What moves a mode need not be what the encoders see of the same order: its answer is a wave of a size and a phase of
    its own. All is linear but the mode's two numbers; what the strengths are is integrated out.
    """

    data: Amplitudes
    within: tuple[_Within, ...]
    form: str
    tried: tuple[tuple[float, ...], ...]
    """natural frequencies and damping ratios from which a mode is sought"""

    @classmethod
    def of(cls, data: Amplitudes) -> Swinging:
        """Of all orders."""
        form, clipped = next(iter(EACH)), Bounds.of(data).clipped
        tried = tuple(clipped(np.log([*law.point[:2], 1.0]))[:2] for law in resonances(data, (form,)))
        return cls(data, tuple(_Within.of(data, k) for k in range(len(data.orders))), form, tried)

    def swings(self, point: Sequence[float]) -> Complex:
        """What a mode adds to each order (revolutions, orders), over the order's strength in it."""
        return EACH[self.form](self.data.frequency, point[0], point[1])

    def each(self, point: Sequence[float]) -> FloatArray:
        """Log-likelihood that each order gains (orders,)."""
        swings = self.swings(point)
        return np.array([float(w.gained(swings[:, [k]])[0, 0]) for k, w in enumerate(self.within)])

    def gain(self, point: Sequence[float]) -> float:
        """What all orders gain, less the price of the mode's numbers."""
        return self._net(self.each(point), point)

    def _net(self, each: FloatArray, point: Sequence[float]) -> float:
        return float(np.sum(np.maximum(each, 0.0))) - self.price(point)

    def price(self, point: Sequence[float]) -> float:
        """Log-likelihood that a mode's two numbers cost, and how unusual its damping is."""
        return unusual(point[1]) + self.of_numbers

    @property
    def of_numbers(self) -> float:
        """Log-likelihood that two numbers cost (BIC)."""
        return float(np.log(2.0 * len(self.data.time)))

    def _of_all(self, courses: Complex, noise: Sequence[Complex | None]) -> FloatArray:
        """What all orders gain by some ``courses`` (revolutions, orders, courses), in their vectors and in draws of
        ``noise``, one array (revolutions, draws) an order: (courses, 1 + draws).
        """
        each = (w.gained(courses[:, k], n) for k, (w, n) in enumerate(zip(self.within, noise, strict=True)))
        return np.asarray(sum(np.maximum(gained, 0.0) for gained in each))

    def most_of(self, laws: Sequence[Law]) -> float:
        """What the best of some laws of the form 1 + e*g gains, and the cubes of speed, temperature and time beside
        them, less the same price.
        """
        data = self.data
        states = np.column_stack([np.abs(data.x), data.time])
        scaled = (states - states.mean(axis=0)) / np.maximum(np.ptp(states, axis=0), 1e-300)
        cubes = [np.repeat(z[:, None] ** 3, len(data.orders), axis=1) for z in scaled.T]
        courses = np.stack([course(law, data) for law in laws] + cubes, axis=2)
        return float(self._of_all(courses, [None] * len(self.within)).max()) - self.of_numbers

    def best(self, begin: Sequence[float]) -> Moved | None:
        """The mode that gains most near one; None where no order gains."""
        data, clipped = self.data, Bounds.of(self.data).clipped
        found = lowest(lambda z: -self.gain(clipped(np.append(z, 0.0))), np.log(begin), STEPS[:2], EVALUATIONS)
        point = clipped(np.append(found, 0.0))[:2]
        gains, swings = self.each(point), self.swings(point)
        taking = [k for k in range(len(self.within)) if gains[k] > 0.0]
        if not taking:
            return None
        strength = np.zeros(len(self.within), dtype=np.complex128)
        for k in taking:
            strength[k] = self.within[k].strength(swings[:, k])
        orders, gain = tuple(data.orders[k] for k in taking), self._net(gains, point)
        law = Law(RESONANCE, self.form, point, gain, orders, strength, ("speed",), data.reference, data.orders)
        return Moved(law, gain, np.maximum(gains, 0.0))

    def maxima(self, rng: np.random.Generator, draws: int) -> tuple[FloatArray, FloatArray]:
        """What each mode that is tried gains in the vectors (modes,), and the best of them all in draws of noise."""
        courses = np.stack([self.swings(point) for point in self.tried], axis=2)
        drawn = [rng.normal(size=(2, len(self.data.time), draws)) for _ in self.within]
        total = self._of_all(courses, [real + 1j * imaginary for real, imaginary in drawn])
        total -= np.array([self.price(point) for point in self.tried])[:, None]
        return total[:, 0], np.max(total[:, 1:], axis=0)


def of_each(data: Amplitudes) -> Moved | None:
    """The mode that best says what some orders have beyond polynomials of the state, each moved as it will; None where
    no order gains.
    """
    swinging = Swinging.of(data)
    return swinging.best(max(swinging.tried, key=swinging.gain))


def beyond_noise(
    data: Amplitudes, others: Sequence[Law], seed: int, draws: int, rate: float
) -> tuple[Moved, float] | None:
    """The mode of :func:`of_each` and how rarely noise alone makes one that gains as much, if more rarely than a
    ``rate``, and if no other law, each order with a strength of its own, says as much.

    The series is not asked, which a strong mode spoils: the vectors are, beside any quadratic polynomials.
    """
    swinging = Swinging.of(data)
    gains, nulls = swinging.maxima(np.random.default_rng([seed, 6]), draws)
    begin = int(np.argmax(gains))
    if gains[begin] < tail(nulls, rate):
        return None
    moved = swinging.best(swinging.tried[begin])
    if moved is None or moved.gain < swinging.most_of(others) + criteria.VERY_STRONG:
        return None
    return moved, tail_rate(nulls, float(gains[begin]))


@dataclass(frozen=True, slots=True)
class _Within:
    """An order's vectors as polynomials of the state, each direction with its own: factor (revolutions, revolutions) of
    their covariance, the vectors under it (revolutions,), and their ``level``.
    """

    lower: FloatArray
    polynomials: FloatArray
    left: Complex
    level: float

    @classmethod
    def of(cls, data: Amplitudes, k: int) -> _Within:
        """Those of order number k."""
        level = float(np.median(np.abs(data.vectors[:, k])))
        covariance = np.zeros((len(data.time), len(data.time)))
        for side, scaling in data.series.scaling.items():
            rows = np.flatnonzero(data.direction * side > 0)
            basis = scaling.monomials(data.x[rows]) * _SPREAD
            covariance[np.ix_(rows, rows)] = level**2 * (basis @ basis.T)
        lower = np.linalg.cholesky(covariance + np.diag(data.sigma[:, k] ** 2))
        left = solve_triangular(lower, data.vectors[:, k], lower=True)
        return cls(np.asarray(lower), covariance, np.asarray(left), level)

    def gained(self, swings: Complex, noise: Complex | None = None) -> FloatArray:
        """Log marginal likelihood gained (modes, 1 + draws) if the vectors, or draws of ``noise`` (revolutions, draws)
        in their place, have some of ``swings`` (revolutions, modes) of the order's size.
        """
        whitened = self._under(swings)
        power = np.sum(np.abs(whitened) ** 2, axis=0)
        left = self.left[:, None] if noise is None else np.column_stack([self.left, noise])
        prior = 2.0 * PRIOR_REVOLUTIONS
        before = np.sum(np.abs(left) ** 2, axis=0)
        after = before - np.abs(np.conj(whitened).T @ left) ** 2 / (1.0 + power)[:, None]
        revolutions = len(self.left) + PRIOR_REVOLUTIONS
        gained = revolutions * np.log((before + prior) / (np.maximum(after, 0.0) + prior))
        return np.asarray(gained - np.log(1.0 + power)[:, None])

    def _under(self, swings: Complex) -> Complex:
        return np.asarray(self.level * solve_triangular(self.lower, swings, lower=True))

    def strength(self, swing: Complex) -> complex:
        """How much of a swing the vectors have, over what they are without it."""
        whitened = self._under(swing)
        share = complex(np.vdot(whitened, self.left)) / (1.0 + float(np.sum(np.abs(whitened) ** 2)))
        rest = solve_triangular(self.lower.T, self.left - share * whitened, lower=False)
        mean = complex(np.mean(self.polynomials @ rest))
        return share * self.level / mean if mean else 0.0j


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
