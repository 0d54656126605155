"""Calibration of the paper's polynomial Fourier series on the vectors of the revolutions.

Amplitude and phase of an order are quadratic polynomials of torque, speed and temperature, a set a direction
(Bauer et al., ICIT 2025, eq. 4). They are fitted to the vector A*exp(j*phi) as identification does
(:mod:`bench.identification.series.polar`); a normal prior, whose spread all orders share, keeps what the design does
not determine near zero (empirical Bayes, MacKay, Neural Comput. 4 (1992) 415).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.identification.series.polar import fit_polynomials, mean_size
from bench.mismatch.orders.revolutions import Complex, Revolution, directions, states
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.sines import phasors, summed
from bench.simulation.waves import ROWS_AT_ONCE, kept_by_mean

FIRST_PRIOR = np.array([0.3, 0.3, 0.3, 0.6, 0.6, 0.6, 0.3, 0.3, 0.3])
"""spread of the polynomials' coefficients before anything is known: of the amplitude (relative); of the phase half as
much again, rad
"""
BEFOREHAND = 1.0
"""coefficients' worth of evidence that a monomial's spread is as usual among all monomials: two speeds say nothing of
what goes with the square of speed, and then it is taken so
"""
INTERPLAY = 0.2
"""spread of products of two quantities, over what it is of squares, before the orders say anything: interactions are
smaller than main effects (effect hierarchy, Wu and Hamada, Experiments, 2009)
"""
LEAST_SPREAD, LARGEST_SPREAD = 5e-4, 2.0
ROUNDS = 4
"""in which orders tell the prior and the prior the orders"""
RELATIVE_NOISE = 1e-3
"""of an order's size: what no polynomial is asked to follow"""
LEAST_SPREADS = np.array([1.0, 1e-3, 0.3])
"""N·m, rad/s and K over which states of revolutions count as varied"""
LEAST_VARIED = 0.1
"""share of the largest torque or speed from which revolutions count as run at several: by less, a control loop and the
noise of the speed vary them, and a polynomial through that says nothing of another speed
"""
WILD = 4.0
"""variance over the noise's from which an order's polynomials are begun afresh"""


@dataclass(frozen=True, slots=True)
class Scaling:
    """Centre and spread of torque, velocity and temperature that keep the polynomials well conditioned."""

    centre: FloatArray
    spread: FloatArray

    @classmethod
    def of(cls, x: FloatArray, parts: FloatArray) -> Scaling:
        """Of states (n, 3) of revolutions: torque, velocity, temperature; those of ``parts`` (k, 3), however many there
        are, lie within two spreads.
        """
        least = np.maximum(LEAST_VARIED * np.max(np.abs(x), axis=0), LEAST_SPREADS)
        least[2] = LEAST_SPREADS[2]  # a temperature has no zero that means anything
        centre = x.mean(axis=0)
        farthest = np.max(np.abs(parts - centre), axis=0, initial=0.0)
        return cls(centre, np.maximum(np.maximum(x.std(axis=0), least), 0.5 * farthest))

    def monomials(self, x: FloatArray) -> FloatArray:
        """The ten monomials (n, 10) of scaled states (n, 3), constant last."""
        z = (x - self.centre) / self.spread
        a, b, c = z.T
        return np.column_stack([a * a, b * b, c * c, a, b, c, a * b, a * c, b * c, np.ones(len(z))])


@dataclass(frozen=True, slots=True)
class Series:
    """A calibrated series. ``amplitude`` and ``phase`` (orders, 10) a direction, in scaled monomials; ``prior``
    (orders, 18) spread of each order's coefficients: nine of the amplitude (relative), nine of the phase; ``doubt``
    (2, orders) variance by which an order misses its polynomials, over its noise; ``loss`` (orders,) weighted squares
    and prior; ``covariance`` a direction (orders, 20, 20) of amplitude and phase together.
    """

    orders: tuple[float, ...]
    scaling: Mapping[int, Scaling]
    amplitude: Mapping[int, FloatArray]
    phase: Mapping[int, FloatArray]
    covariance: Mapping[int, FloatArray]
    prior: FloatArray
    doubt: FloatArray
    loss: FloatArray

    def vectors(self, x: FloatArray, direction: FloatArray) -> Complex:
        """A*exp(j*phi) of every order (n, orders) for states (n, 3) and directions (n,)."""
        out = np.zeros((len(x), len(self.orders)), dtype=np.complex128)
        for side in self.amplitude:
            rows = direction * side > 0
            if rows.any():
                basis = self.scaling[side].monomials(x[rows])
                out[rows] = (basis @ self.amplitude[side].T) * phasors(basis @ self.phase[side].T)
        return out

    def variance(self, x: FloatArray, direction: FloatArray, span: FloatArray | None = None) -> FloatArray:
        """Variance (n,) of the series at states (n, 3), over all angles, by what its coefficients are known to,
        rad²; of its means over angles ``span`` (n,), rad, where they are given.
        """
        out = np.zeros(len(x))
        over = np.zeros(len(x)) if span is None else span
        for side in self.amplitude:
            rows = direction * side > 0
            if not rows.any():
                continue
            basis = self.scaling[side].monomials(x[rows])
            amplitude = basis @ self.amplitude[side].T
            for k in range(len(self.orders)):
                of_amplitude = np.einsum("ni,ij,nj->n", basis, self.covariance[side][k, :10, :10], basis)
                of_phase = np.einsum("ni,ij,nj->n", basis, self.covariance[side][k, 10:, 10:], basis)
                # a phase that is not known at all turns a wave by its own size at most
                smear = kept_by_mean(self.orders[k], over[rows]) ** 2
                out[rows] += 0.5 * smear * (of_amplitude + amplitude[:, k] ** 2 * np.minimum(of_phase, 2.0))
        return out

    def less(self, orders: Collection[float]) -> Series:
        """The same series without some orders."""
        keep = [k for k, f in enumerate(self.orders) if f not in orders]

        def rows(table: Mapping[int, FloatArray]) -> dict[int, FloatArray]:
            return {side: values[keep] for side, values in table.items()}

        return replace(
            self,
            orders=tuple(self.orders[k] for k in keep),
            amplitude=rows(self.amplitude),
            phase=rows(self.phase),
            covariance=rows(self.covariance),
            prior=self.prior[keep],
            doubt=self.doubt[:, keep],
            loss=self.loss[keep],
        )

    def evaluate(self, frame: Frame) -> FloatArray:
        """The series at the rows of a frame, rad; 0 in a direction that was never calibrated."""
        return self._summed(frame, np.ones(len(self.orders)), 0.0)

    def slope(self, frame: Frame) -> FloatArray:
        """Change of the series with the angle, rad/rad: an order's wave a quarter period ahead, times the order."""
        return self._summed(frame, np.asarray(self.orders), 0.5 * np.pi)

    def _summed(self, frame: Frame, factor: FloatArray, ahead: float) -> FloatArray:
        out = np.zeros(frame.size)
        orders = np.asarray(self.orders)
        for side in self.amplitude:
            rows = np.flatnonzero(frame.last_direction * side > 0)
            for a in range(0, rows.size, ROWS_AT_ONCE):
                part = rows[a : a + ROWS_AT_ONCE]
                x = np.column_stack([frame.torque[part], frame.velocity[part], frame.temperature[part]])
                basis = self.scaling[side].monomials(x)
                amplitude = (self.amplitude[side] * factor[:, None]) @ basis.T
                out[part] = summed(frame.theta[part], orders, amplitude, self.phase[side] @ basis.T + ahead)
        return out


def calibrate(
    revolutions: Sequence[Revolution],
    vectors: Complex,
    noise: FloatArray,
    orders: Sequence[float],
    parts: Sequence[Revolution] = (),
    given: Collection[float] | None = None,
) -> Series:
    """Fit amplitude and phase polynomials to ``vectors`` (revolutions, orders) whose components have ``noise``
    (revolutions, orders). The prior is of states that vary as far as those of the ``parts`` which will refine them; it
    and the coefficients are learnt in some rounds.

    ``given``: orders of the simulation (None: all). They tell a prior of their own: those of the teeth change with the
    state, and what else stands in a gearbox, often many weak ones, hardly does.
    """
    x, direction = states(revolutions), directions(revolutions)
    sides = [s for s in (1, -1) if np.any(direction * s > 0)]
    further, its_direction = states(parts), directions(parts)
    scalings = {s: Scaling.of(x[direction * s > 0], further[its_direction * s > 0]) for s in sides}
    number = len(orders)
    of_simulation = np.array([given is None or f in given for f in orders], dtype=bool)
    groups = [group for group in (np.flatnonzero(of_simulation), np.flatnonzero(~of_simulation)) if group.size]
    amplitude = {s: np.zeros((number, 10)) for s in sides}
    phase = {s: np.zeros((number, 10)) for s in sides}
    covariance = {s: np.zeros((number, 20, 20)) for s in sides}
    prior = np.tile(np.concatenate([FIRST_PRIOR, 1.5 * FIRST_PRIOR]), (number, 1))
    doubt = np.ones((2, number))
    loss = np.zeros(number)
    found, determined = np.zeros((len(sides), number, 18)), np.zeros((len(sides), number, 18))
    for step in range(ROUNDS):
        loss[:] = 0.0
        for number_of_side, side in enumerate(sides):
            rows = direction * side > 0
            basis = scalings[side].monomials(x[rows])
            row = 0 if side > 0 else 1
            for k in range(number):
                begin = None
                if step and doubt[row, k] < WILD:
                    begin = np.concatenate([amplitude[side][k], phase[side][k]])
                spread = noise[rows, k] * np.sqrt(doubt[row, k])
                fit = fit_order(basis, vectors[rows, k], spread, prior[k], begin)
                loss[k] += fit.loss
                amplitude[side][k], phase[side][k], covariance[side][k] = fit.amplitude, fit.phase, fit.covariance
                size = mean_size(vectors[rows, k])
                found[number_of_side, k] = np.concatenate([fit.amplitude[:9] / size, fit.phase[:9]])
                determined[number_of_side, k] = fit.determined
                left = vectors[rows, k] - (basis @ fit.amplitude) * np.exp(1j * (basis @ fit.phase))
                free = max(2.0 * rows.sum() - 2.0 - fit.determined.sum(), 2.0)
                square = np.sum(np.abs(left) ** 2 / (noise[rows, k] ** 2 + (RELATIVE_NOISE * size) ** 2))
                doubt[row, k] = max(1.0, float(square / free))
        for group in groups if sides else ():
            prior[group] = _empirical_prior(found[:, group].reshape(-1, 18), determined[:, group].reshape(-1, 18))
    return Series(tuple(float(f) for f in orders), scalings, amplitude, phase, covariance, prior, doubt, loss)


def first_prior() -> FloatArray:
    """Spread of the coefficients (18,) before an order says anything: of the amplitude's, relative, and the phase's.

    :func:`calibrate` begins with wider ones of products, which its rounds narrow.
    """
    first = np.concatenate([FIRST_PRIOR, 1.5 * FIRST_PRIOR])
    first[[6, 7, 8, 15, 16, 17]] *= INTERPLAY
    return first


def _empirical_prior(found: FloatArray, determined: FloatArray) -> FloatArray:
    """Spread of each monomial's coefficient over all orders and directions (18,): the orders tell one another what is
    usual.

    ``found`` (sets, 18) coefficients; ``determined`` (sets, 18) the share of each that the data say and not the prior
    (MacKay's effective number of parameters): what the prior alone holds at zero is no evidence for a small spread.
    """
    limit = np.maximum(3.0 * np.median(np.abs(found), axis=0) / 0.6745, 1e-9)
    # a mean of squares that a single wild order does not rule
    squares = np.minimum(np.abs(found), limit) ** 2
    first = first_prior()
    for part in (slice(0, 9), slice(9, 18)):  # how much the amplitudes depend on anything, and the phases
        if determined[:, part].sum() >= 1.0:  # revolutions at one state do not say
            first[part] *= np.sqrt(squares[:, part].sum() / float(np.sum(determined[:, part] * first[part] ** 2)))
    usual = np.sqrt((squares.sum(axis=0) + BEFOREHAND * first**2) / (determined.sum(axis=0) + BEFOREHAND))
    return np.asarray(np.clip(usual, LEAST_SPREAD, LARGEST_SPREAD))


@dataclass(frozen=True, slots=True)
class OrderFit:
    """Polynomials of one order: amplitude (10,) rad, phase (10,) rad, the loss, covariance (20, 20) of both, how far
    (0 to 1) the data rather than the prior determine each coefficient but the constants (18,), and the ``size`` that
    the amplitude's prior is relative to, rad.
    """

    amplitude: FloatArray
    phase: FloatArray
    loss: float
    covariance: FloatArray
    determined: FloatArray
    size: float


def fit_order(
    basis: FloatArray, vector: Complex, sigma: FloatArray, spread: FloatArray, begin: FloatArray | None = None
) -> OrderFit:
    """Fit one order's ``vector`` (n,) at the states of ``basis`` (n, 10); ``sigma`` (n,) noise of a component,
    ``spread`` (18,) of the coefficients; from ``begin`` (20,), or from a level vector and from a smooth one.
    """
    size = mean_size(vector)
    variance = sigma**2 + (RELATIVE_NOISE * size) ** 2
    prior = np.concatenate([spread[:9] * size, [np.inf], spread[9:], [np.inf]])
    starts = [begin] if begin is not None else [_level(vector, size), _smooth(basis, vector, size)]
    found = fit_polynomials(basis, vector, variance, variance, starts, None, prior)
    keep = [*range(9), *range(10, 19)]
    return OrderFit(
        found.amplitude,
        found.phase,
        found.squares,
        found.covariance,
        np.clip(1.0 - found.open_share[keep], 0.0, 1.0),
        size,
    )


def _level(vector: Complex, size: float) -> FloatArray:
    return np.concatenate([np.append(np.zeros(9), size), np.append(np.zeros(9), np.angle(np.sum(vector)))])


def _smooth(basis: FloatArray, vector: Complex, size: float) -> FloatArray:
    """Start from a smooth linear fit of the vectors: its modulus and unwrapped phase, fitted each."""
    few = basis[:, [3, 4, 5, 9]]
    ridge = 0.05 * np.eye(4) * len(vector)
    ridge[3, 3] = 1e-6
    smooth = few @ np.linalg.solve(few.T @ few + ridge, few.T @ vector)
    middle = np.angle(np.sum(smooth))
    angle = np.angle(smooth * np.exp(-1j * middle)) + middle
    heavy = 0.3 * np.eye(10)
    heavy[9, 9] = 1e-6
    inverse = np.linalg.inv(basis.T @ basis + heavy)
    del size
    return np.concatenate([inverse @ basis.T @ np.abs(smooth), inverse @ basis.T @ angle])
