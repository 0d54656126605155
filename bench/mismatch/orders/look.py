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
            normal, right = self._by_fft(y, weight, np.round(orders * parts).astype(np.int64), parts)
        else:
            waves = self.theta[:, None] * orders
            design = np.column_stack([np.ones(self.theta.size), self.line, np.cos(waves), np.sin(waves)])
            weighted = design * weight[:, None]
            normal, right = weighted.T @ design, weighted.T @ y
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

    def _by_fft(
        self, y: FloatArray, weight: FloatArray, orders: NDArray[np.int64], parts: int
    ) -> tuple[FloatArray, FloatArray]:
        highest = int(orders.max())
        w, ws = self._of_weights(weight, highest, parts)
        wy = self._spectrum(weight * y, highest, parts)
        k = orders.size
        difference, total = orders[:, None] - orders[None, :], orders[:, None] + orders[None, :]
        c_minus, s_minus = w.real[np.abs(difference)], np.sign(difference) * w.imag[np.abs(difference)]
        c_plus, s_plus = w.real[total], w.imag[total]
        normal = np.empty((2 * k + 2, 2 * k + 2))
        normal[2 : 2 + k, 2 : 2 + k] = 0.5 * (c_minus + c_plus)
        normal[2 + k :, 2 + k :] = 0.5 * (c_minus - c_plus)
        # cos(f)*sin(g) = (sin(g + f) + sin(g - f))/2
        normal[2 : 2 + k, 2 + k :] = 0.5 * (s_plus - s_minus)
        normal[2 + k :, 2 : 2 + k] = normal[2 : 2 + k, 2 + k :].T
        normal[0, 0], normal[0, 1], normal[1, 1] = w[0].real, ws[0].real, float(np.sum(weight * self.line**2))
        normal[1, 0] = normal[0, 1]
        normal[0, 2:] = np.concatenate([w.real[orders], w.imag[orders]])
        normal[1, 2:] = np.concatenate([ws.real[orders], ws.imag[orders]])
        normal[2:, 0], normal[2:, 1] = normal[0, 2:], normal[1, 2:]
        means = [wy[0].real, float(np.sum(weight * self.line * y))]
        return normal, np.concatenate([means, wy.real[orders], wy.imag[orders]])

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
