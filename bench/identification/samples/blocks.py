"""Short blocks of a whole recording: means of channels, rates from angles; what the slow equations are fitted to."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

BLOCK_S = 0.05
STANDSTILL_RAD_S = 0.3
"""Motor speed below which the bench counts as standing: a block of 50 ms resolves 0.015 rad/s."""


@dataclass(frozen=True, slots=True)
class Blocks:
    """One row each :data:`BLOCK_S`, in the order of time, averaged under a triangle of twice that length.

    A quantity whose channel is missing is NaN. SI units, temperatures in °C. ``acceleration`` is at the motor shaft,
    ``load_size`` the mean of |load torque|; ``steady`` is 1 inside steady segments and ``whole`` is 0 where rows of the
    recording are missing inside the block or its neighbours.
    """

    time: FloatArray
    motor_velocity: FloatArray
    load_velocity: FloatArray
    load_angle: FloatArray
    acceleration: FloatArray
    load_acceleration: FloatArray
    motor_torque: FloatArray
    load_torque: FloatArray
    load_motor_torque: FloatArray
    load_size: FloatArray
    temperature: FloatArray
    ambient_temperature: FloatArray
    steady: FloatArray
    whole: FloatArray

    @property
    def size(self) -> int:
        """Number of blocks."""
        return int(self.time.size)

    @property
    def direction(self) -> FloatArray:
        """Sign of the motion, 0 at standstill."""
        return np.where(np.abs(self.motor_velocity) > STANDSTILL_RAD_S, np.sign(self.motor_velocity), 0.0)


FIELDS = tuple(f.name for f in fields(Blocks))
MEANS = ("motor_torque", "load_torque", "load_motor_torque", "temperature", "ambient_temperature")


def _triangle(x: FloatArray, width: int) -> FloatArray:
    """Mean (B − 1,) of x (B·width,) under the triangle of two block lengths about the first sample of the second.

    A sample is of the instant it is taken at, as an angle is: half a sample of difference between torque and speed
    would pass for a thousandth of the inertia, by way of the viscous friction.
    """
    rise = np.arange(width) / width
    both = x.reshape(-1, width) @ np.column_stack([rise, 1.0 - rise])
    return np.asarray((both[:-1, 0] + both[1:, 1]) / width)


def _rates(angle: FloatArray, width: int, rate: float) -> tuple[FloatArray, FloatArray]:
    """First and second derivative under the same triangle, from an angle (B·width + 1,).

    The triangle is a box convolved with itself, so its mean of ω̇ is the difference of two block means of ω, and its
    mean of ω the difference of two block means of the angle: no filter to choose, none that differs between channels.
    """
    step = width / rate
    offset = angle - angle[0]
    # trapezoids, so that the mean is of the same instants as the second derivative
    mean = 0.5 * (offset[:-1] + offset[1:]).reshape(-1, width).mean(axis=1)
    speed = np.diff(offset[::width]) / step
    return np.diff(mean) / step, np.diff(speed) / step


def make_blocks(
    channels: dict[str, FloatArray], sample_rate: float, steady: NDArray[np.bool_], gaps: NDArray[np.int64]
) -> Blocks:
    """Reduce channels (N,) in SI units to blocks; ``gaps`` are the samples before which rows are missing."""
    size = next(iter(channels.values())).size
    width = max(2, round(BLOCK_S * sample_rate))
    count = (size - 1) // width
    if count < 2:
        return Blocks(**{name: np.empty(0) for name in FIELDS})
    used = count * width
    nothing = np.full(count - 1, np.nan)

    def mean(name: str) -> FloatArray:
        return _triangle(channels[name][:used], width) if name in channels else nothing

    def rates(angle: str, velocity: str) -> tuple[FloatArray, FloatArray]:
        if angle in channels:
            return _rates(channels[angle][: used + 1], width, sample_rate)
        if velocity in channels:
            block = channels[velocity][:used].reshape(count, width).mean(axis=1)
            return mean(velocity), np.diff(block) * sample_rate / width
        return nothing, nothing

    whole = np.ones(count - 1)
    for gap in gaps // width:
        whole[max(gap - 2, 0) : gap + 2] = 0.0
    within = np.asarray(steady[:used].reshape(count, width).all(axis=1), dtype=np.float64)
    motor_velocity, acceleration = rates("motor_angle", "motor_velocity")
    load_velocity, load_acceleration = rates("load_angle", "load_velocity")
    return Blocks(
        time=_triangle(channels["time"][:used], width),
        motor_velocity=motor_velocity,
        load_velocity=load_velocity,
        load_angle=mean("load_angle"),
        acceleration=acceleration,
        load_acceleration=load_acceleration,
        **{name: mean(name) for name in MEANS},
        load_size=_triangle(np.abs(channels["load_torque"][:used]), width) if "load_torque" in channels else nothing,
        steady=within[1:] * within[:-1],
        whole=whole,
    )
