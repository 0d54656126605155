"""Orders in the rows of one steady revolution: their amplitudes by least squares, and the spectrum of what is left.

y(theta) = b_0 + b_1*s + sum of a_f*cos(f*theta) + b_f*sin(f*theta) is fitted to all rows of a steady segment at once,
s a line through it. For whole orders the normal equations are sums of exp(j*f*theta) at sums and differences of the
orders, which one non-uniform FFT gives; so a hundred orders cost little more than one. What depends on the angles alone
is kept: the same revolution is looked at again with every order that is found.
"""

from __future__ import annotations

from dataclasses import dataclass

import finufft
import numpy as np
from numpy.typing import NDArray

from bench.identification.samples.spikes import off_median
from bench.mismatch import criteria
from bench.mismatch.recordings.notch import ACCURACY, spectrum
from bench.mismatch.recordings.rows import ANGLE_STEP
from bench.mismatch.regression.noise import robust_spread
from bench.simulation.frame import FloatArray
from bench.simulation.waves import kept_by_mean, of_orders

Complex = NDArray[np.complex128]

HIGHEST_ORDER = 1500
CLOSE = 1e-12
"""relative accuracy of sums at any orders: two that are near each other in one revolution are told apart by little"""
PARTS = 12
"""of an order: halves, thirds, quarters and sixths stand between the whole ones where ratios are no whole numbers"""


@dataclass(frozen=True, slots=True)
class Rest:
    """What a revolution is left with: ``values`` (n,) times weights of a sum ``total``, 0 outside whole revolutions."""

    theta: FloatArray
    values: FloatArray
    total: float

    def between(self, highest: int) -> Complex:
        """Vectors b + j*a at parts of an order, 0 ... ``highest`` of them."""
        return _vectors(spectrum(self.theta / PARTS, self.values, highest), self.total)


def _vectors(sums: Complex, total: float) -> Complex:
    """Vectors b + j*a from sums of weighted values times exp(j*f*theta)."""
    return np.asarray(1j * np.conj(2.0 / total * sums))


@dataclass(frozen=True, slots=True)
class Shown:
    """What a revolution shows: ``vectors`` (k,) b + j*a of the fitted orders, what is ``left`` at every whole order
    (HIGHEST_ORDER + 1,), noise of a row (``white``), and the ``rest``.
    """

    vectors: Complex
    left: Complex
    white: float
    rest: Rest


@dataclass(frozen=True, slots=True)
class _Sums:
    """Sums of exp(j*f*theta) over the rows, for k orders: times the weights at differences ``minus`` and totals
    ``plus`` of two orders (k, k); at the orders (k,) times the ``weight``, that times the ``line``, that times ``y``.
    """

    minus: Complex
    plus: Complex
    weight: Complex
    line: Complex
    y: Complex


class Look:
    """Rows of one steady revolution: angles ``theta`` (n,), ``number`` (n,) of samples in each, place among all rows,
    and how far (rad) from the first they are ``whole`` revolutions.
    """

    def __init__(self, theta: FloatArray, number: FloatArray, rows: slice, whole: float) -> None:
        self.rows = rows
        self.theta = np.ascontiguousarray(theta)
        self.line = (theta - theta.mean()) / max(float(np.ptp(theta)), 1e-9)
        self.weight = number / max(float(number.max()), 1.0)
        self._valid = number > 0
        self._whole = np.abs(theta - theta[0]) <= whole
        self._plan: tuple[int, finufft.Plan] | None = None
        self._weights: dict[int, tuple[Complex, Complex]] = {}

    def fitted(self, y: FloatArray, orders: FloatArray) -> Shown:
        """Fit ``orders`` (k,) to ``y`` (all rows,)."""
        values, weight = y[self.rows], self.weight
        beta = self._fit(values, weight, orders)
        residual = values - self._sum(beta, orders)
        spread = robust_spread(residual[self._valid])
        # a wild row stands alone: a pulse of the gearbox is as large in its neighbours
        far = off_median(residual) > criteria.SPIKE * spread
        if far[self._valid].any():  # rows far off the first fit are left out of a second
            weight = np.where(far, 0.0, weight)
            beta = self._fit(values, weight, orders)
            residual = values - self._sum(beta, orders)
        smear = kept_by_mean(orders, ANGLE_STEP)
        k = orders.size
        vectors = (beta[2 + k :] + 1j * beta[2 : 2 + k]) / smear
        weight = np.where(self._whole, weight, 0.0)
        rest = Rest(self.theta, residual * weight, max(float(weight.sum()), 1e-12))
        left = _vectors(self._spectrum(rest.values, HIGHEST_ORDER), rest.total)
        left /= np.maximum(kept_by_mean(np.arange(HIGHEST_ORDER + 1.0), ANGLE_STEP), 0.2)
        return Shown(np.asarray(vectors, dtype=np.complex128), left, spread, rest)

    def _spectrum(self, values: FloatArray, highest: int, parts: int = 1) -> Complex:
        """Sum of values*exp(j*f*theta) for multiples f of an order's part, 0 ... ``highest``."""
        if parts != 1:
            return spectrum(self.theta / parts, values, highest)
        if self._plan is None or self._plan[0] < highest:
            most = max(highest, HIGHEST_ORDER)
            plan = finufft.Plan(1, (2 * most + 1,), eps=ACCURACY, isign=1, nthreads=1)
            plan.setpts(np.mod(self.theta, 2.0 * np.pi))
            self._plan = most, plan
        most, plan = self._plan
        return np.asarray(plan.execute(values.astype(np.complex128))[most : most + highest + 1])

    def _fit(self, y: FloatArray, weight: FloatArray, orders: FloatArray) -> FloatArray:
        """Coefficients: constant, line, cosines, sines."""
        parts = parts_of(orders)
        if parts and float(orders.max()) <= HIGHEST_ORDER:
            sums = self._by_fft(y, weight, np.round(orders * parts).astype(np.int64), parts)
        else:
            sums = self._anywhere(y, weight, orders)
        normal, right = self._equations(y, weight, sums)
        normal[np.diag_indices_from(normal)] *= 1.0 + 1e-10
        return np.asarray(np.linalg.solve(normal, right))

    def _of_weights(self, weight: FloatArray, highest: int, parts: int) -> tuple[Complex, Complex]:
        """Spectra of the weights up to twice an order, and of the weights times the line up to it."""
        known = self._weights.get(parts) if weight is self.weight else None
        if known is None or known[1].size <= highest:
            both = self._spectrum(weight, 2 * highest, parts), self._spectrum(weight * self.line, highest, parts)
            if weight is self.weight:
                self._weights[parts] = both
            return both
        return known

    def _by_fft(self, y: FloatArray, weight: FloatArray, orders: NDArray[np.int64], parts: int) -> _Sums:
        """Sums for multiples of an order's part."""
        highest = int(orders.max())
        w, ws = self._of_weights(weight, highest, parts)
        wy = self._spectrum(weight * y, highest, parts)
        difference, total = orders[:, None] - orders[None, :], orders[:, None] + orders[None, :]
        minus = w[np.abs(difference)]
        return _Sums(np.where(difference < 0, np.conj(minus), minus), w[total], w[orders], ws[orders], wy[orders])

    def _anywhere(self, y: FloatArray, weight: FloatArray, orders: FloatArray) -> _Sums:
        """Sums for any orders (non-uniform FFT from any angles to any orders)."""
        middle, k = float(self.theta.mean()), orders.size
        angle = self.theta - middle

        def at(values: FloatArray, asked: FloatArray) -> Complex:
            strengths = np.ascontiguousarray(values.astype(np.complex128))
            turned = finufft.nufft1d3(angle, strengths, asked, eps=CLOSE, isign=1, nthreads=1)
            return np.asarray(turned * np.exp(1j * asked * middle))

        rows, columns = np.triu_indices(k)
        asked = np.concatenate([orders[rows] - orders[columns], orders[rows] + orders[columns], orders])
        of_weight = at(weight, np.ascontiguousarray(asked))
        minus, plus = (np.empty((k, k), dtype=np.complex128) for _ in range(2))
        minus[rows, columns], plus[rows, columns] = of_weight[: rows.size], of_weight[rows.size : 2 * rows.size]
        minus[columns, rows], plus[columns, rows] = np.conj(minus[rows, columns]), plus[rows, columns]
        asked = np.ascontiguousarray(orders, dtype=np.float64)
        return _Sums(minus, plus, of_weight[2 * rows.size :], at(weight * self.line, asked), at(weight * y, asked))

    def _equations(self, y: FloatArray, weight: FloatArray, sums: _Sums) -> tuple[FloatArray, FloatArray]:
        """Normal matrix and right side of constant, line, cosines and sines."""
        k = sums.weight.size
        normal = np.empty((2 * k + 2, 2 * k + 2))
        normal[2 : 2 + k, 2 : 2 + k] = 0.5 * (sums.minus.real + sums.plus.real)
        normal[2 + k :, 2 + k :] = 0.5 * (sums.minus.real - sums.plus.real)
        # cos(f)*sin(g) = (sin(g + f) + sin(g - f))/2
        normal[2 : 2 + k, 2 + k :] = 0.5 * (sums.plus.imag - sums.minus.imag)
        normal[2 + k :, 2 : 2 + k] = normal[2 : 2 + k, 2 + k :].T
        weighted = weight * self.line
        normal[0, 0], normal[0, 1], normal[1, 1] = weight.sum(), weighted.sum(), float(weighted @ self.line)
        normal[1, 0] = normal[0, 1]
        normal[0, 2:] = np.concatenate([sums.weight.real, sums.weight.imag])
        normal[1, 2:] = np.concatenate([sums.line.real, sums.line.imag])
        normal[2:, 0], normal[2:, 1] = normal[0, 2:], normal[1, 2:]
        return normal, np.concatenate([[weight @ y, weighted @ y], sums.y.real, sums.y.imag])

    def _sum(self, beta: FloatArray, orders: FloatArray) -> FloatArray:
        """The fitted waves at the rows."""
        k = orders.size
        waves = of_orders(self.theta, orders, beta[2 : 2 + k], beta[2 + k :])
        return np.asarray(beta[0] + beta[1] * self.line + waves)


def parts_of(orders: FloatArray) -> int:
    """1 where all orders are whole, PARTS where they are whole numbers of such parts, else 0."""
    if not orders.size:
        return 0
    for parts in (1, PARTS):
        if np.all(np.abs(orders * parts - np.round(orders * parts)) < 1e-9):
            return parts
    return 0
