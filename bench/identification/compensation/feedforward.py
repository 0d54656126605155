"""The model's feedforward on the set value, so that the load side follows its set motion.

With TE = q − θ the motor must be sent to θ_d = q_d − TE(θ_d): the error is taken off beforehand. Adding it, as a
figure of the paper has it, doubles the error. In cyclic synchronous velocity the drive is sent the derivative,

    θ̇_d = q̇_d / (1 + TE'(θ_d)),

as a chain of short phases in which the velocity goes linearly from one value to the next.

The same error also turns the load's torque into a torque that swings at the motor, TE'·τ/u, and the drive's velocity
loop gives way to it: at 700 N·m by a fifth of the speed it is asked for. With the loop's parameters known
(:class:`Loop`) the set velocity takes that off, too.
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


@dataclass(frozen=True, slots=True)
class Loop:
    """A drive's velocity loop and its shaft: what a set speed needs so that the shaft has the speed.

    Attributes
    ----------
    gain : proportional gain, N·m·s/rad; ``integral_time`` : s.
    inertia : kg·m², ``viscous`` : N·m·s/rad at the motor shaft; ``ratio`` : u.
    """

    gain: float
    integral_time: float
    inertia: float
    viscous: float
    ratio: float

    def extra(self, series: Series, share: float, torque: float, velocity: float) -> Series:
        """Return what to add to the set speed, rad/s at the load side, as a series of its own.

        ``share`` of the error is taken off at ``velocity`` rad/s and ``torque`` N·m. The shaft needs the torque
        TE'·τ/u + (J·s + f_v)·δω beyond a constant one, and the loop gives K·(1 + 1/(T·s)) of the speed it lacks.
        """
        slope = series.amplitude * series.orders * np.exp(1j * series.phase)
        rate = 1j * series.orders * velocity
        wanted = -share * self.ratio * velocity * slope
        needed = slope * torque / self.ratio + (self.inertia * rate + self.viscous) * wanted
        lacking = needed * rate * self.integral_time / (self.gain * (1.0 + rate * self.integral_time))
        # a cosine in the series' terms: sin(x + π/2)
        return Series(series.orders, np.abs(lacking) / self.ratio, np.angle(lacking) + 0.5 * np.pi)


def input_angle(series: Series, load_angle: FloatArray) -> FloatArray:
    """Solve θ_d = q_d − TE(θ_d) by fixed-point iteration; it contracts by |TE'|, some 1e-3 a step."""
    theta = load_angle.copy()
    for _ in range(4):
        theta = load_angle - series.value(theta)
    return theta


def steady_phases(
    series: Series,
    start_angle: float,
    velocity: float,
    duration_s: float,
    load_torque: float,
    gain: float = 1.0,
    extra: Series | None = None,
) -> tuple[Phase, ...]:
    """Phases of steady motion of the load side with the feedforward.

    Parameters
    ----------
    series : the error at this operating point.
    start_angle : θ at the beginning, rad.
    velocity : q̇_d, rad/s.
    gain : 1 takes the error off, 0 leaves the motion plain, −1 adds it (as the paper's figure has it).
    extra : added to the set speed for the drive's loop (:class:`Loop`).
    """
    count = max(2, round(duration_s / STEP_S))
    time = np.arange(1, count + 1) * STEP_S
    scaled = Series(series.orders, gain * series.amplitude, series.phase)
    begin = start_angle + float(scaled.value(np.array([start_angle]))[0])
    theta = input_angle(scaled, np.asarray(begin + velocity * time, dtype=np.float64))
    speed = velocity / (1.0 + scaled.slope(theta))
    if extra is not None:
        speed = speed + extra.value(theta)
    return tuple(Phase(Segment.STEADY, STEP_S, float(v), load_torque) for v in speed)


SPEED_S = 0.005
"""Time over which a speed is taken: 0.2 µrad of an angle's noise are then 0.05 mrad/s."""


@dataclass(frozen=True, slots=True)
class Left:
    """What is left of the error: RMS of q − q_d in rad, and of the load side's speed about its set value in rad/s."""

    rmse: float
    speed: float


def ripple_free(
    time: FloatArray,
    theta: FloatArray,
    load_angle: FloatArray,
    velocity: float,
    notch_orders: Sequence[int],
    orders: FloatArray,
) -> Left:
    """RMS of q − q_d and of its rate over whole revolutions: mean, trend and the load motor's ripple taken off.

    q_d is motion at ``velocity`` from wherever the load side began; a trend is the rounding of the set velocity,
    not the gearbox's. It is separated from the slow orders by fitting ``orders`` with it, which are left in. The rate
    is that of :data:`SPEED_S`, by differences.
    """
    error = load_angle - velocity * time
    x = [np.ones_like(time), time - time.mean()]
    for order in notch_orders:
        x += [np.sin(order * theta), np.cos(order * theta)]
    taken = len(x)
    for order in orders:
        if order not in notch_orders:
            x += [np.sin(order * theta), np.cos(order * theta)]
    columns = np.column_stack(x)
    # by normal equations: hundreds of orders over whole revolutions are all but orthogonal
    scale = np.linalg.norm(columns, axis=0)
    columns /= scale
    coefficients = np.linalg.solve(columns.T @ columns, columns.T @ error)
    rest = error - columns[:, :taken] @ coefficients[:taken]
    step = max(1, round(SPEED_S / float(np.median(np.diff(time)))))
    rate = (rest[step:] - rest[:-step]) / (time[step:] - time[:-step])
    return Left(float(np.sqrt(np.mean(rest**2))), float(np.sqrt(np.mean(rate**2))))
