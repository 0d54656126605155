"""Calibration of the paper's polynomial Fourier series on complex amplitudes, and its evaluation at any row.

Amplitude and phase of an order are quadratic polynomials of torque, speed and temperature, a set a direction (paper,
eq. 4). They are fitted to the vector A·exp(jφ), which knows no wrapping, by damped Gauss-Newton steps from several
starts; a weak prior keeps what the design does not determine near zero.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numba
import numpy as np
from numpy.typing import NDArray

from bench.mismatch.spectrum import Complex, Turn, states
from bench.simulation.frame import FloatArray, Frame

FIRST_PRIOR = np.array([0.3, 0.3, 0.3, 0.6, 0.6, 0.6, 0.3, 0.3, 0.3])
"""spread of the polynomials' coefficients before anything is known: of the amplitude (relative), and of the phase in
rad
"""
LEAST_SPREAD, LARGEST_SPREAD = 5e-4, 2.0
WILD = 4.0
ROWS_AT_ONCE = 1 << 15
_ROUNDS = 8
_STEPS = 60


@dataclass(frozen=True, slots=True)
class Scaling:
    """Centre and spread of torque, velocity and temperature that keep the polynomials well conditioned."""

    centre: FloatArray
    spread: FloatArray

    def monomials(self, x: FloatArray) -> FloatArray:
        """The ten monomials (n, 10) of scaled states (n, 3), constant last."""
        z = np.clip((x - self.centre) / self.spread, -2.5, 2.5)
        a, b, c = z.T
        return np.column_stack([a * a, b * b, c * c, a, b, c, a * b, a * c, b * c, np.ones(len(z))])


@dataclass(frozen=True, slots=True)
class Series:
    """A calibrated series. ``amplitude`` and ``phase`` (orders, 10) a direction, in scaled monomials."""

    orders: tuple[float, ...]
    scaling: Mapping[int, Scaling]
    amplitude: Mapping[int, FloatArray]
    phase: Mapping[int, FloatArray]
    misfit: FloatArray
    """root mean square of what amplitude and phase miss of the vectors they were fitted to, an order"""
    prior: FloatArray
    """spread of the coefficients over the orders (18,): nine of the amplitude (relative), nine of the phase"""
    loss: FloatArray
    """weighted squares and prior of each order's fit, both directions together (orders,)"""

    def vectors(self, x: FloatArray, direction: FloatArray) -> Complex:
        """A·exp(jφ) of every order (n, orders) for states (n, 3) and directions (n,)."""
        out = np.zeros((len(x), len(self.orders)), dtype=np.complex128)
        for side in self.amplitude:
            rows = direction * side > 0
            if rows.any():
                basis = self.scaling[side].monomials(x[rows])
                out[rows] = (basis @ self.amplitude[side].T) * np.exp(1j * (basis @ self.phase[side].T))
        return out

    def less(self, orders: Collection[float]) -> Series:
        """The same series without some orders."""
        keep = [k for k, f in enumerate(self.orders) if f not in orders]
        return replace(
            self,
            orders=tuple(self.orders[k] for k in keep),
            amplitude={side: table[keep] for side, table in self.amplitude.items()},
            phase={side: table[keep] for side, table in self.phase.items()},
            misfit=self.misfit[keep],
            loss=self.loss[keep],
        )

    def evaluate(self, frame: Frame) -> FloatArray:
        """The series at the rows of a frame, rad; 0 in a direction that was never calibrated."""
        return self._summed(frame, np.ones(len(self.orders)), 0.0)

    def slope(self, frame: Frame, step: float) -> FloatArray:
        """The series' difference over an angle of ``step`` to either side of the rows, a rad of angle."""
        # (sin(p + f·h) - sin(p - f·h)) / 2h = cos(p)·sin(f·h)/h
        return self._summed(frame, np.sin(np.asarray(self.orders) * step) / step, 0.5 * np.pi)

    def _summed(self, frame: Frame, factor: FloatArray, ahead: float) -> FloatArray:
        """Sum of the orders, each times its ``factor`` and with its phase ``ahead``."""
        out = np.zeros(frame.size)
        orders = np.asarray(self.orders)
        for side in self.amplitude:
            rows = np.flatnonzero(frame.last_direction * side > 0)
            for a in range(0, rows.size, ROWS_AT_ONCE):
                own = rows[a : a + ROWS_AT_ONCE]
                x = np.column_stack([frame.torque[own], frame.velocity[own], frame.temperature[own]])
                basis = self.scaling[side].monomials(x)
                amplitude, phase = (basis @ (self.amplitude[side] * factor[:, None]).T), basis @ self.phase[side].T
                out[own] = _sum(frame.theta[own], orders, amplitude, phase + ahead)
        return out


@numba.njit(cache=True)
def _sum(theta: FloatArray, orders: FloatArray, amplitude: FloatArray, phase: FloatArray) -> FloatArray:
    out = np.zeros(theta.size)
    for i in range(theta.size):
        for k in range(orders.size):
            out[i] += amplitude[i, k] * np.sin(orders[k] * theta[i] + phase[i, k])
    return out


def noise_at(turn_list: Sequence[Turn], orders: Sequence[float]) -> FloatArray:
    """Standard deviation of one component of each turn's vectors at the orders, (turns, orders)."""
    return np.array([[t.sigma[int(min(round(f), t.sigma.size - 1))] for f in orders] for t in turn_list])


def as_vectors(turn_list: Sequence[Turn]) -> Complex:
    """A·exp(jφ) = b + j·a of each turn and order, (turns, orders), from a·cos + b·sin."""
    return np.array([1j * np.conj(t.amplitude) for t in turn_list])


def calibrate(
    turn_list: Sequence[Turn],
    vectors: Complex,
    orders: Sequence[float],
    noise: FloatArray | None = None,
    known_prior: FloatArray | None = None,
) -> Series:
    """Fit amplitude and phase polynomials to vectors (turns, orders) of the turns given.

    ``noise`` (turns, orders) replaces the turns' own; with ``known_prior`` the spread of the coefficients is given and
    one round is made, else it is learnt from all orders in a few.
    """
    sides = (1, -1)
    x = states(turn_list)
    direction = np.array([t.direction for t in turn_list])
    sigma = noise_at(turn_list, orders) if noise is None else noise
    scalings: dict[int, Scaling] = {}
    amplitude: dict[int, FloatArray] = {}
    phase: dict[int, FloatArray] = {}
    misfit = np.zeros((2, len(orders)))
    # coefficients in units of their prior's kind (relative to the order's size, rad), and how far each is determined
    found = np.zeros((2, len(orders), 18))
    determined = np.zeros((2, len(orders), 18))
    prior = np.concatenate([FIRST_PRIOR, 1.5 * FIRST_PRIOR]) if known_prior is None else known_prior
    loss = np.zeros(len(orders))
    # variance by which an order misses its polynomials, over its noise: they say nothing then, and must not go wild
    doubt = np.ones((2, len(orders)))
    for step in range(_ROUNDS if known_prior is None else 1):
        loss[:] = 0.0
        for number, side in enumerate(sides):
            rows = direction * side > 0
            if not rows.any():
                continue
            spread = np.maximum(x[rows].std(axis=0), [1.0, 1e-3, 0.3])
            scalings[side] = Scaling(x[rows].mean(axis=0), spread)
            basis = scalings[side].monomials(x[rows])
            before = (amplitude[side], phase[side]) if step else None
            amplitude[side] = np.zeros((len(orders), 10))
            phase[side] = np.zeros((len(orders), 10))
            for k in range(len(orders)):
                tame = before is not None and doubt[number, k] < WILD
                start = np.concatenate([before[0][k], before[1][k]]) if before is not None and tame else None
                own = sigma[rows, k] * np.sqrt(doubt[number, k])
                a, p, cost, freedom = fit_order(basis, vectors[rows, k], own, prior, start)
                loss[k] += cost
                amplitude[side][k], phase[side][k] = a, p
                size = np.sqrt(np.mean(np.abs(vectors[rows, k]) ** 2)) or 1e-12
                found[number, k] = np.concatenate([a[:9] / size, p[:9]])
                determined[number, k] = freedom
                left = vectors[rows, k] - (basis @ a) * np.exp(1j * (basis @ p))
                misfit[number, k] = np.sqrt(np.mean(np.abs(left) ** 2))
                if known_prior is None:
                    free = max(2.0 * rows.sum() - 2.0 - freedom.sum(), 2.0)
                    square = np.sum(np.abs(left) ** 2 / (sigma[rows, k] ** 2 + (1e-3 * size) ** 2))
                    doubt[number, k] = max(1.0, float(square / free))
        if known_prior is None:
            # a direction in which the bench was never driven says nothing about what is usual
            driven = [number for number, side in enumerate(sides) if side in amplitude]
            prior = _empirical_prior(found[driven].reshape(-1, 18), determined[driven].reshape(-1, 18))
    return Series(tuple(float(f) for f in orders), scalings, amplitude, phase, misfit.max(axis=0), prior, loss)


def _empirical_prior(found: FloatArray, determined: FloatArray) -> FloatArray:
    """Spread of each monomial's coefficient over all orders and directions (18,): the orders tell one another what is
    usual.

    ``found`` (sets, 18) coefficients; ``determined`` (sets, 18) the share of each that the data say and not the prior
    (MacKay's effective number of parameters): what the prior alone holds at zero is no evidence for a small spread.
    """
    limit = np.maximum(3.0 * np.median(np.abs(found), axis=0) / 0.6745, 1e-9)
    # a mean of squares that a single wild order does not rule
    squares = np.minimum(np.abs(found), limit) ** 2
    usual = np.sqrt(squares.sum(axis=0) / np.maximum(determined.sum(axis=0), 0.5))
    return np.asarray(np.clip(usual, LEAST_SPREAD, LARGEST_SPREAD))


def fit_order(
    basis: FloatArray,
    vector: Complex,
    sigma: FloatArray,
    spread: FloatArray | None = None,
    start: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray, float, FloatArray]:
    """Amplitude and phase polynomials (10,), (10,) of one order from its vectors at the states of ``basis`` (n, 10);
    the loss; and how far (0 … 1) the data rather than the prior determine each coefficient but the constants (18,).

    Noise is what the spectrum says and a thousandth of the amplitude.
    """
    size = float(np.sqrt(np.mean(np.abs(vector) ** 2))) or 1e-12
    middle = np.angle(np.sum(vector))
    best: tuple[float, FloatArray, FloatArray] | None = None
    prior = np.concatenate([FIRST_PRIOR, 1.5 * FIRST_PRIOR]) if spread is None else spread
    weight = 1.0 / np.sqrt(sigma**2 + (1e-3 * size) ** 2)
    starts = [np.concatenate([np.append(np.zeros(9), size), np.append(np.zeros(9), middle)])]
    starts.append(_linear_start(basis, vector, size))
    if start is not None:
        starts = [start]
    for begin in starts:
        loss, found, determined = _gauss_newton(basis, vector, weight, begin, size, prior)
        if best is None or loss < best[0]:
            best = (loss, found, determined)
    assert best is not None
    keep = [*range(9), *range(10, 19)]
    return best[1][:10].copy(), best[1][10:].copy(), best[0], best[2][keep]


def _value(basis: FloatArray, x: FloatArray) -> Complex:
    return np.asarray((basis @ x[:10]) * np.exp(1j * (basis @ x[10:])))


def _linear_start(basis: FloatArray, vector: Complex, size: float) -> FloatArray:
    """Start from a smooth linear fit of the vectors: its modulus and unwrapped phase, fitted each."""
    few = basis[:, [3, 4, 5, 9]]
    ridge = 0.05 * np.eye(4) * len(vector)
    ridge[3, 3] = 1e-6
    smooth = few @ np.linalg.solve(few.T @ few + ridge, few.T @ vector)
    turn = np.exp(-1j * np.angle(np.sum(smooth)))
    angle = np.angle(smooth * turn) - np.angle(turn)
    heavy = 0.3 * np.eye(10)
    heavy[9, 9] = 1e-6
    inverse = np.linalg.inv(basis.T @ basis + heavy)
    return np.concatenate([inverse @ basis.T @ np.abs(smooth), inverse @ basis.T @ angle]) if size > 0 else np.zeros(20)


def _gauss_newton(
    basis: FloatArray, vector: Complex, weight: FloatArray, start: FloatArray, size: float, spread: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    prior = np.concatenate([1.0 / (spread[:9] * size), [0.0], 1.0 / spread[9:], [0.0]])

    def loss_of(x: FloatArray) -> float:
        left = (vector - _value(basis, x)) * weight
        return float(np.sum(left.real**2 + left.imag**2) + np.sum((prior * x) ** 2))

    x = start.copy()
    loss = loss_of(x)
    damping = 1e-3
    normal = np.eye(20)
    for _ in range(_STEPS):
        phase = np.exp(1j * (basis @ x[10:]))
        value = (basis @ x[:10]) * phase
        jacobian = np.hstack([phase[:, None] * basis, 1j * value[:, None] * basis]) * weight[:, None]
        real = np.vstack([jacobian.real, jacobian.imag])
        left = (vector - value) * weight
        gradient = real.T @ np.concatenate([left.real, left.imag]) - prior**2 * x
        normal = real.T @ real + np.diag(prior**2)
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), gradient)
        tried = x + step
        after = loss_of(tried)
        if after < loss:
            done = loss - after < 1e-7 * loss
            x, loss, damping = tried, after, damping * 0.2
            if done:
                break
        else:
            damping *= 8.0
            if damping > 1e8:
                break
    # scaled by the prior: unit prior precision in each coefficient that has one
    scale = np.where(prior > 0, 1.0 / np.maximum(prior, 1e-300), size)
    variance = np.diag(np.linalg.inv(normal * scale[:, None] * scale[None, :]))
    return loss, x, np.clip(1.0 - variance, 0.0, 1.0)


def mask(turn_list: Sequence[Turn], recordings: set[int]) -> NDArray[np.bool_]:
    """Which turns belong to the recordings given."""
    return np.array([t.recording in recordings for t in turn_list], dtype=bool)
