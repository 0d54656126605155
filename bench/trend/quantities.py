"""What a gearbox is judged by, and how it is read from the model of a campaign at a reference point.

Amplitudes, hysteresis and stiffness are those of the identified polynomials without load, at one speed and temperature
that the campaign measured, or nothing: a polynomial says nothing of where nobody measured.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.simulation import TERM_COUNT, FourierSet, basis

FloatArray = NDArray[np.float64]

TORQUE_MARGIN_NM = 50.0
"""Torques this near to none count as none."""
SPEED_MARGIN = 1.01
"""A reference speed counts as measured if recordings are as fast, and as slow, within this factor."""
TEMPERATURE_MARGIN_K = 0.5
"""A reference temperature is a whole °C and counts as measured if recordings, rounded to whole °C, have it."""


@dataclass(frozen=True, slots=True)
class Value:
    """A value, its standard deviation and the degrees of freedom that one rests on."""

    value: float
    std: float
    freedom: float = math.inf


@dataclass(frozen=True, slots=True)
class Quantity:
    """What is followed: ``key`` for programs, ``name`` and ``unit`` for people, ``scale`` from SI to the unit."""

    key: str
    name: str
    unit: str
    scale: float = 1.0


@dataclass(frozen=True, slots=True)
class Reference:
    """Where values are read, without load: load-side speed in °/s, temperature in °C."""

    speed_deg_s: float
    temperature_degc: float

    def row(self, sign: float) -> FloatArray:
        """Monomials (10,) of the reference point in a direction."""
        return basis(0.0, sign * math.radians(self.speed_deg_s), self.temperature_degc)

    def measured(self, least: Sequence[float], most: Sequence[float]) -> bool:
        """Whether recordings between ``least`` and ``most`` (3,), τ N·m, |q̇| °/s and °C, hold this point."""
        return bool(
            least[0] <= TORQUE_MARGIN_NM
            and most[0] >= -TORQUE_MARGIN_NM
            and least[1] / SPEED_MARGIN <= self.speed_deg_s <= most[1] * SPEED_MARGIN
            and least[2] - TEMPERATURE_MARGIN_K <= self.temperature_degc <= most[2] + TEMPERATURE_MARGIN_K
        )


def amplitude(fourier: FourierSet, order: float, x: FloatArray, freedom: float) -> Value | None:
    """Amplitude of an order in rad at monomials ``x`` (10,); None where the model has no order or no covariance."""
    at = np.flatnonzero(fourier.orders == order)
    if at.size == 0 or fourier.covariance is None:
        return None
    k = int(at[0])
    size = float(fourier.amplitude[k] @ x)
    return _value(abs(size), float(x @ fourier.covariance[k][:TERM_COUNT, :TERM_COUNT] @ x), freedom)


def hysteresis(positive: FourierSet, negative: FourierSet, row: tuple[FloatArray, FloatArray], freedom: float) -> Value:
    """Width in rad between both directions' mean errors without load, at monomials of each direction (10,)."""
    size = float(positive.offset @ row[0] - negative.offset @ row[1])
    assert positive.offset_covariance is not None
    assert negative.offset_covariance is not None
    square = float(row[0] @ positive.offset_covariance @ row[0] + row[1] @ negative.offset_covariance @ row[1])
    return Value(abs(size), math.sqrt(square), freedom)


def stiffness(fourier: FourierSet, x: FloatArray, freedom: float) -> Value | None:
    """Torsional stiffness in N·m/rad at monomials ``x`` (10,): −1 / (∂a₀/∂τ); None where no torque was varied."""
    covariance = fourier.offset_covariance
    # without several torques there is no term of the torque
    if covariance is None or covariance[3, 3] <= 0.0:
        return None
    gradient = np.zeros(TERM_COUNT)
    gradient[3], gradient[6], gradient[7] = 1.0, x[4], x[5]
    compliance = -float(fourier.offset @ gradient)
    if compliance <= 0.0:
        return None
    return _value(1.0 / compliance, float(gradient @ covariance @ gradient) / compliance**4, freedom)


def _value(value: float, square: float, freedom: float) -> Value | None:
    """A value whose variance is known, else nothing: without one it has no place on a chart."""
    return Value(value, math.sqrt(square), freedom) if square > 0.0 and math.isfinite(square) else None
