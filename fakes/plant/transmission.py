"""The transmission error: a Fourier series whose amplitudes, phases and offset are polynomials of the state.

    TE = Σ_k A_k sin(f_k θ + φ_k) + a_0      (Bauer et al., ICIT 2025)

with A_k, φ_k, a_0 quadratic polynomials in (τ, θ̇, T), one set a direction. The polynomials are evaluated at a slow rate
as the cosine and sine parts A cos φ and A sin φ, in between both are interpolated linearly; the orders' sines and
cosines are turned by the angle of each cycle and made exact again at every slow evaluation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

POSITIVE, NEGATIVE = 0, 1
_SMALL_ANGLE = 0.4
"""angle in rad up to which the short series below is exact to 1e-12"""


@dataclass(frozen=True, slots=True)
class Scale:
    """Coordinates in which a plant file writes its polynomials: x = τ/torque, y = θ̇/velocity, z = (T − centre)/span."""

    torque: float
    velocity: float
    temperature_centre: float
    temperature_span: float

    def to_raw(self, scaled: FloatArray) -> FloatArray:
        """Convert coefficients (..., 10) in (x, y, z) to the paper's, in τ (N·m), θ̇ (rad/s), T (°C)."""
        p = np.moveaxis(np.asarray(scaled, dtype=np.float64), -1, 0)
        a, b, c, centre = 1 / self.torque, 1 / self.velocity, 1 / self.temperature_span, self.temperature_centre
        return np.stack(
            [
                p[0] * a * a,
                p[1] * b * b,
                p[2] * c * c,
                (p[3] - p[7] * centre * c) * a,
                (p[4] - p[8] * centre * c) * b,
                (p[5] - 2 * p[2] * centre * c) * c,
                p[6] * a * b,
                p[7] * a * c,
                p[8] * b * c,
                p[9] - p[5] * centre * c + p[2] * (centre * c) ** 2,
            ],
            axis=-1,
        )


@dataclass(frozen=True, slots=True)
class Box:
    """Bounds of (τ, θ̇, T) within which the polynomials hold; outside the state is taken to the nearest bound."""

    torque: tuple[float, float]
    velocity: tuple[float, float]
    temperature: tuple[float, float]

    def array(self) -> FloatArray:
        """Return the bounds as (3, 2)."""
        return np.array([self.torque, self.velocity, self.temperature])


@dataclass(frozen=True, slots=True)
class TransmissionError:
    """Coefficients of the whole series, paper's order of terms i = 1 … 10, SI units and °C.

    ``orders`` (K,) ascending; ``amplitude`` and ``phase`` (2, K, 10) with the positive direction first; ``offset``
    (2, 10) is a_0 *without* its elastic part −τ/K, which the torsional spring of the plant makes by itself;
    ``weak`` (K,) marks the orders that the paper's model neglects.
    """

    orders: FloatArray
    amplitude: FloatArray
    phase: FloatArray
    offset: FloatArray
    weak: NDArray[np.bool_]
    box: Box

    def without_weak_orders(self) -> TransmissionError:
        """Return the series that the paper's model can describe exactly."""
        keep = ~self.weak
        return TransmissionError(
            self.orders[keep], self.amplitude[:, keep], self.phase[:, keep], self.offset, self.weak[keep], self.box
        )

    def coefficients(self, stiffness: float) -> dict[str, dict[str, Mapping[str, list[float]] | list[float]]]:
        """Return the series as a simulation file writes it, with the elastic part −τ/``stiffness`` in a_0."""
        tables: dict[str, dict[str, Mapping[str, list[float]] | list[float]]] = {}
        for direction, name in ((POSITIVE, "positive"), (NEGATIVE, "negative")):
            table: dict[str, Mapping[str, list[float]] | list[float]] = {}
            for k, order in enumerate(self.orders):
                table[f"{order:g}"] = {
                    "A": self.amplitude[direction, k].tolist(),
                    "phi": self.phase[direction, k].tolist(),
                }
            offset = self.offset[direction].copy()
            offset[3] -= 1.0 / stiffness
            table["a0"] = offset.tolist()
            tables[name] = table
        return tables

    def evaluate(
        self, theta: FloatArray, torque: FloatArray, velocity: FloatArray, temperature: FloatArray, stiffness: float
    ) -> FloatArray:
        """Return the noise-free transmission error in rad at arrays of state; the elastic part included.

        ``theta`` rad (input angle over ratio), ``torque`` N·m, ``velocity`` rad/s at the output (its sign chooses the
        direction, 0 counts as positive), ``temperature`` °C; all broadcast against each other.
        """
        arrays = np.broadcast_arrays(theta, torque, velocity, temperature)
        theta, torque, velocity, temperature = (np.asarray(a, dtype=np.float64) for a in arrays)
        t, v, c = (
            np.clip(value, low, high)
            for value, (low, high) in zip((torque, velocity, temperature), self.box.array(), strict=True)
        )
        basis = np.stack([t * t, v * v, c * c, t, v, c, t * v, t * c, v * c, np.ones_like(t)], axis=-1)
        result = np.zeros(theta.shape)
        for direction, mask in ((POSITIVE, velocity >= 0), (NEGATIVE, velocity < 0)):
            row = basis[mask]
            part = row @ self.offset[direction]
            for k, order in enumerate(self.orders):
                amplitude = row @ self.amplitude[direction, k]
                part = part + amplitude * np.sin(order * theta[mask] + row @ self.phase[direction, k])
            result[mask] = part
        return result - torque / stiffness


@njit(cache=True, error_model="numpy")
def _clamp(value: float, low: float, high: float) -> float:
    """Return the value within [low, high]."""
    return float(min(max(value, low), high))


@njit(cache=True, error_model="numpy")
def _dot(c: Any, t: float, v: float, k: float) -> float:
    """Evaluate the paper's polynomial with coefficients ``c`` (10,)."""
    linear = (c[0] * t + c[3] + c[6] * v + c[7] * k) * t + (c[1] * v + c[4] + c[8] * k) * v
    return float(linear + (c[2] * k + c[5]) * k + c[9])


@njit(cache=True, error_model="numpy")
def aim(
    target: FloatArray,
    amplitude: FloatArray,
    phase: FloatArray,
    offset: FloatArray,
    box: FloatArray,
    torque: float,
    velocity: float,
    temperature: float,
    weight: float,
) -> None:
    """Fill ``target`` (2, K + 1) with A cos φ, A sin φ of each order and, in [0, K], a_0 without its elastic part.

    ``weight`` in [−1, 1] blends the directions: 1 positive, −1 negative.
    """
    t = _clamp(torque, box[0, 0], box[0, 1])
    v = _clamp(velocity, box[1, 0], box[1, 1])
    k = _clamp(temperature, box[2, 0], box[2, 1])
    target[:] = 0.0
    last = target.shape[1] - 1
    for direction in range(2):
        share = 0.5 + 0.5 * weight if direction == 0 else 0.5 - 0.5 * weight
        if share <= 0.0:
            continue
        for i in range(last):
            a = share * _dot(amplitude[direction, i], t, v, k)
            p = _dot(phase[direction, i], t, v, k)
            target[0, i] += a * math.cos(p)
            target[1, i] += a * math.sin(p)
        target[0, last] += share * _dot(offset[direction], t, v, k)


@njit(cache=True, error_model="numpy")
def place(sine_cosine: FloatArray, orders: FloatArray, theta: float) -> None:
    """Fill ``sine_cosine`` (2, K) with the exact sines and cosines of the orders at ``theta``."""
    for i in range(orders.shape[0]):
        sine_cosine[0, i] = math.sin(orders[i] * theta)
        sine_cosine[1, i] = math.cos(orders[i] * theta)


@njit(cache=True, error_model="numpy")
def rotate(sine_cosine: FloatArray, orders: FloatArray, change: float) -> None:
    """Turn the orders' sines and cosines on by ``change`` in θ. ``orders`` (K,) ascend.

    The series of sine and cosine (to x⁹ and x⁸) leaves an error below 1e-12 a turn up to 0.4 rad; higher orders take
    the exact functions.
    """
    count = orders.shape[0]
    size = abs(change)
    short = count
    while short > 0 and orders[short - 1] * size > _SMALL_ANGLE:
        short -= 1
    for i in range(short):
        x = orders[i] * change
        z = x * x
        s = x * (1.0 - z * (1 / 6 - z * (1 / 120 - z * (1 / 5040 - z / 362880))))
        c = 1.0 - z * (0.5 - z * (1 / 24 - z * (1 / 720 - z * (1 / 40320 - z / 3628800))))
        sine = sine_cosine[0, i]
        sine_cosine[0, i] = sine * c + sine_cosine[1, i] * s
        sine_cosine[1, i] = sine_cosine[1, i] * c - sine * s
    for i in range(short, count):
        s = math.sin(orders[i] * change)
        c = math.cos(orders[i] * change)
        sine = sine_cosine[0, i]
        sine_cosine[0, i] = sine * c + sine_cosine[1, i] * s
        sine_cosine[1, i] = sine_cosine[1, i] * c - sine * s


@njit(cache=True, error_model="numpy")
def advance(parts: FloatArray, slope: FloatArray) -> None:
    """Move the interpolated parts (2, K + 1) one cycle along their slopes."""
    for row in range(2):
        for i in range(parts.shape[1]):
            parts[row, i] += slope[row, i]


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})  # sums in SIMD lanes; NaN stays NaN
def series(sine_cosine: FloatArray, parts: FloatArray, orders: FloatArray) -> tuple[float, float, float]:
    """Return the transmission error without its elastic part, and its first and second derivatives in θ."""
    count = orders.shape[0]
    value = parts[0, count]
    first = 0.0
    second = 0.0
    for i in range(count):
        sine = sine_cosine[0, i]
        cosine = sine_cosine[1, i]
        f = orders[i]
        here = parts[0, i] * sine + parts[1, i] * cosine
        value += here
        first += f * (parts[0, i] * cosine - parts[1, i] * sine)
        second -= f * f * here
    return value, first, second


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
def drift(sine_cosine: FloatArray, slope: FloatArray) -> float:
    """Return the change of the transmission error in a cycle that the ``slope`` of its parts makes."""
    count = sine_cosine.shape[1]
    change = slope[0, count]
    for i in range(count):
        change += slope[0, i] * sine_cosine[0, i] + slope[1, i] * sine_cosine[1, i]
    return float(change)
