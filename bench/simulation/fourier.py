"""The transmission error as a Fourier series whose amplitudes and phases depend on torque, velocity and temperature.

TE_d(θ; τ, θ̇, T) = Σ_k A_k·sin(f_k·θ + φ_k) + a₀, with A_k, φ_k and a₀ each a polynomial of
:mod:`bench.simulation.polynomial` and one set a direction of motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from bench.simulation.polynomial import TERM_COUNT

FloatArray = NDArray[np.float64]


@njit(cache=True)
def _series(
    theta: FloatArray, orders: FloatArray, amplitude: FloatArray, phase: FloatArray, offset: FloatArray
) -> FloatArray:
    out = np.empty(theta.size)
    rows, sets = amplitude.shape[0], offset.size
    for n in range(theta.size):
        row = n if rows > 1 else 0
        value = offset[n if sets > 1 else 0]
        for k in range(orders.size):
            value += amplitude[row, k] * np.sin(orders[k] * theta[n] + phase[row, k])
        out[n] = value
    return out


@njit(cache=True)
def _polynomial_series(
    theta: FloatArray,
    torque: FloatArray,
    velocity: FloatArray,
    temperature: FloatArray,
    orders: FloatArray,
    amplitude: FloatArray,
    phase: FloatArray,
    offset: FloatArray,
) -> FloatArray:
    out = np.empty(theta.size)
    x = np.empty(TERM_COUNT)
    for n in range(theta.size):
        t, v, c = torque[n], velocity[n], temperature[n]
        x[0], x[1], x[2], x[3], x[4] = t * t, v * v, c * c, t, v
        x[5], x[6], x[7], x[8], x[9] = c, t * v, t * c, v * c, 1.0
        value = 0.0
        for i in range(TERM_COUNT):
            value += offset[i] * x[i]
        for k in range(orders.size):
            a = 0.0
            p = 0.0
            for i in range(TERM_COUNT):
                a += amplitude[k, i] * x[i]
                p += phase[k, i] * x[i]
            value += a * np.sin(orders[k] * theta[n] + p)
        out[n] = value
    return out


def evaluate(
    theta: ArrayLike, orders: ArrayLike, amplitude: ArrayLike, phase: ArrayLike, offset: ArrayLike = 0.0
) -> FloatArray:
    """Evaluate Σ_k A_k·sin(f_k·θ + φ_k) + a₀, shape (N,), in rad.

    Parameters
    ----------
    theta : (N,) rad, motor angle / ratio.
    orders : (K,) per output revolution.
    amplitude, phase : (K,) constant, or (N, K) one row a sample; rad.
    offset : scalar or (N,), rad.
    """
    angle = np.ascontiguousarray(theta, dtype=np.float64)
    a, p = np.atleast_2d(np.asarray(amplitude, dtype=np.float64)), np.atleast_2d(np.asarray(phase, dtype=np.float64))
    if a.shape != p.shape or a.shape[0] not in (1, angle.size):
        raise ValueError(f"amplitude {a.shape} and phase {p.shape} must both be (K,) or ({angle.size}, K)")
    f = np.atleast_1d(np.asarray(orders, dtype=np.float64))
    a0 = np.atleast_1d(np.asarray(offset, dtype=np.float64))
    result: FloatArray = _series(angle, f, np.ascontiguousarray(a), np.ascontiguousarray(p), a0)
    return result


@dataclass(frozen=True, slots=True)
class FourierSet:
    """Coefficients of one direction of motion, for raw inputs τ N·m, θ̇ rad/s, T °C.

    Attributes
    ----------
    orders : (K,) per output revolution.
    amplitude, phase : (K, 10) polynomial coefficients of A_k and φ_k, rad.
    offset : (10,) coefficients of a₀, rad.
    amplitude_std, phase_std, offset_std : standard deviations of the same shapes, None where not known.
    covariance : (K, 20, 20) of (A_k, φ_k) together, None where not known.
    offset_covariance : (10, 10), None where not known.
    """

    orders: FloatArray
    amplitude: FloatArray
    phase: FloatArray
    offset: FloatArray
    amplitude_std: FloatArray | None = None
    phase_std: FloatArray | None = None
    offset_std: FloatArray | None = None
    covariance: FloatArray | None = None
    offset_covariance: FloatArray | None = None

    @classmethod
    def zeros(cls, orders: Sequence[float]) -> FourierSet:
        """Return a set with all coefficients 0."""
        size = len(orders)
        return cls(
            np.asarray(orders, dtype=np.float64),
            np.zeros((size, TERM_COUNT)),
            np.zeros((size, TERM_COUNT)),
            np.zeros(TERM_COUNT),
        )

    def evaluate(
        self, theta: ArrayLike, torque: ArrayLike, velocity: ArrayLike, temperature: ArrayLike, *, offset: bool = True
    ) -> FloatArray:
        """Transmission error (N,) in rad at angles (N,), inputs scalar or (N,); without a₀ if ``offset`` is False."""
        angle = np.ascontiguousarray(theta, dtype=np.float64)
        inputs = [
            np.ascontiguousarray(np.broadcast_to(np.asarray(x, dtype=np.float64), angle.shape))
            for x in (torque, velocity, temperature)
        ]
        a0 = self.offset if offset else np.zeros(TERM_COUNT)
        result: FloatArray = _polynomial_series(
            angle,
            inputs[0],
            inputs[1],
            inputs[2],
            np.ascontiguousarray(self.orders),
            np.ascontiguousarray(self.amplitude),
            np.ascontiguousarray(self.phase),
            np.ascontiguousarray(a0),
        )
        return result

    def select(self, orders: Sequence[float]) -> FourierSet:
        """Keep only the orders listed (those the set has)."""
        keep = np.isin(self.orders, np.asarray(orders, dtype=np.float64))

        def rows(values: FloatArray | None) -> FloatArray | None:
            return None if values is None else values[keep]

        return replace(
            self,
            orders=self.orders[keep],
            amplitude=self.amplitude[keep],
            phase=self.phase[keep],
            amplitude_std=rows(self.amplitude_std),
            phase_std=rows(self.phase_std),
            covariance=rows(self.covariance),
        )


@dataclass(frozen=True, slots=True)
class TransmissionErrorModel:
    """One :class:`FourierSet` a direction of motion; None where a direction was never measured."""

    positive: FourierSet | None
    negative: FourierSet | None

    def direction(self, sign: float) -> FourierSet | None:
        """Return the set in force for a direction of motion (its sign; 0 counts as positive)."""
        return self.negative if sign < 0 else self.positive

    def evaluate(
        self, theta: ArrayLike, torque: ArrayLike, velocity: ArrayLike, temperature: ArrayLike, direction: ArrayLike
    ) -> FloatArray:
        """Transmission error (N,) in rad, NaN where that set is missing; ``direction`` is the last motion's sign."""
        angle = np.asarray(theta, dtype=np.float64)
        sign = np.broadcast_to(np.asarray(direction, dtype=np.float64), angle.shape)
        inputs = [
            np.broadcast_to(np.asarray(x, dtype=np.float64), angle.shape) for x in (torque, velocity, temperature)
        ]
        out = np.full(angle.shape, np.nan)
        for rows, fourier in ((sign >= 0, self.positive), (sign < 0, self.negative)):
            if fourier is not None and rows.any():
                out[rows] = fourier.evaluate(angle[rows], *(x[rows] for x in inputs))
        return out
