"""The model's feedforward on the set value, so that the load side follows its set motion.

With TE = q − θ the motor must be sent to θ_d = q_d − TE(θ_d): the error is taken off beforehand. Adding it, as a
figure of the paper has it, doubles the error. In cyclic synchronous velocity the drive is sent the derivative,

    θ̇_d = q̇_d / (1 + TE'(θ_d)),

as a chain of short phases in which the velocity goes linearly from one value to the next.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.protocols import Phase, Segment
from bench.simulation import FourierSet, basis

FloatArray = NDArray[np.float64]

STEP_S = 0.005
"""Length of a phase: order 276 at 10 deg/s turns in 130 ms."""


@dataclass(frozen=True, slots=True)
class Series:
    """A series at one operating point: orders (K,) with amplitudes and phases (K,), rad."""

    orders: FloatArray
    amplitude: FloatArray
    phase: FloatArray

    @classmethod
    def at(cls, fourier: FourierSet, torque: float, velocity: float, temperature: float) -> Series:
        """Evaluate the polynomials at N·m, rad/s at the load side, °C."""
        row = basis(torque, velocity, temperature)
        return cls(fourier.orders, fourier.amplitude @ row, fourier.phase @ row)

    def value(self, theta: FloatArray) -> FloatArray:
        """Transmission error (N,) in rad without its offset."""
        return np.asarray(np.sin(np.outer(theta, self.orders) + self.phase) @ self.amplitude)

    def slope(self, theta: FloatArray) -> FloatArray:
        """Its derivative by θ (N,), rad/rad."""
        return np.asarray(np.cos(np.outer(theta, self.orders) + self.phase) @ (self.amplitude * self.orders))


def input_angle(series: Series, load_angle: FloatArray) -> FloatArray:
    """Solve θ_d = q_d − TE(θ_d) by fixed-point iteration; it contracts by |TE'|, some 1e-3 a step."""
    theta = load_angle.copy()
    for _ in range(4):
        theta = load_angle - series.value(theta)
    return theta


def steady_phases(
    series: Series, start_angle: float, velocity: float, duration_s: float, load_torque: float, gain: float = 1.0
) -> tuple[Phase, ...]:
    """Phases of steady motion of the load side with the feedforward.

    Parameters
    ----------
    series : the error at this operating point.
    start_angle : θ at the beginning, rad.
    velocity : q̇_d, rad/s.
    gain : 1 takes the error off, 0 leaves the motion plain, −1 adds it (as the paper's figure has it).
    """
    count = max(2, round(duration_s / STEP_S))
    time = np.arange(1, count + 1) * STEP_S
    scaled = Series(series.orders, gain * series.amplitude, series.phase)
    begin = start_angle + float(scaled.value(np.array([start_angle]))[0])
    theta = input_angle(scaled, np.asarray(begin + velocity * time, dtype=np.float64))
    speed = velocity / (1.0 + scaled.slope(theta))
    return tuple(Phase(Segment.STEADY, STEP_S, float(v), load_torque) for v in speed)


def ripple_free_rmse(
    time: FloatArray,
    theta: FloatArray,
    load_angle: FloatArray,
    velocity: float,
    notch_orders: Sequence[int],
    orders: FloatArray,
) -> float:
    """RMS of q − q_d in rad over whole revolutions: mean, trend and the load motor's ripple taken off.

    q_d is motion at ``velocity`` from wherever the load side began; a trend is the rounding of the set velocity,
    not the gearbox's. It is told from the slow orders by fitting ``orders`` with it, which are left in.
    """
    error = load_angle - velocity * time
    x = [np.ones_like(time), time - time.mean()]
    for order in notch_orders:
        x += [np.sin(order * theta), np.cos(order * theta)]
    taken = len(x)
    for order in orders:
        x += [np.sin(order * theta), np.cos(order * theta)]
    columns = np.column_stack(x)
    coefficients = np.linalg.lstsq(columns, error, rcond=None)[0]
    rest = error - columns[:, :taken] @ coefficients[:taken]
    return float(np.sqrt(np.mean(rest**2)))
