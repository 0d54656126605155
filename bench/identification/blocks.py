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
    """One row a block of :data:`BLOCK_S`, in the order of time; a quantity whose channel is missing is NaN.

    SI units, temperatures in °C. ``acceleration`` is at the motor shaft; ``steady`` is 1 inside steady segments and
    ``whole`` is 0 where rows of the recording are missing inside the block or its neighbours.
    """

    time: FloatArray
    motor_velocity: FloatArray
    load_velocity: FloatArray
    acceleration: FloatArray
    load_acceleration: FloatArray
    motor_torque: FloatArray
    load_torque: FloatArray
    load_motor_torque: FloatArray
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


def _centred(x: FloatArray) -> FloatArray:
    """Average over two block lengths about each block: the same window a central difference of block speeds sees."""
    if x.size < 3:
        return x
    out = x.copy()
    out[1:-1] = 0.25 * x[:-2] + 0.5 * x[1:-1] + 0.25 * x[2:]
    return out


def _slope(angle: FloatArray, width: int, rate: float) -> FloatArray:
    """Least-squares slope of each row of ``width`` samples, rad/s."""
    weight = np.arange(width) - (width - 1) / 2.0
    rows = angle.reshape(-1, width)
    return np.asarray((rows - rows[:, :1]) @ weight / (weight @ weight) * rate)


def _rate(slope: FloatArray, block_s: float) -> FloatArray:
    return np.gradient(slope, block_s) if slope.size > 2 else np.zeros_like(slope)


def make_blocks(
    channels: dict[str, FloatArray], sample_rate: float, steady: NDArray[np.bool_], gaps: NDArray[np.int64]
) -> Blocks:
    """Reduce channels (N,) in SI units to blocks; ``gaps`` are the samples before which rows are missing."""
    size = next(iter(channels.values())).size
    width = max(2, round(BLOCK_S * sample_rate))
    count = size // width
    used = count * width
    block_s = width / sample_rate
    nothing = np.full(count, np.nan)

    def mean(name: str) -> FloatArray:
        return _centred(channels[name][:used].reshape(count, width).mean(axis=1)) if name in channels else nothing

    def speed(angle: str, velocity: str) -> FloatArray:
        if angle in channels:
            return _slope(channels[angle][:used], width, sample_rate)
        if velocity in channels:
            return np.asarray(channels[velocity][:used].reshape(count, width).mean(axis=1))
        return nothing

    whole = np.ones(count)
    for gap in gaps // width:
        whole[max(gap - 1, 0) : gap + 2] = 0.0
    motor, load = speed("motor_angle", "motor_velocity"), speed("load_angle", "load_velocity")
    return Blocks(
        time=channels["time"][:used].reshape(count, width).mean(axis=1),
        motor_velocity=_centred(motor),
        load_velocity=_centred(load),
        acceleration=_rate(motor, block_s),
        load_acceleration=_rate(load, block_s),
        **{name: mean(name) for name in MEANS},
        steady=np.asarray(steady[:used].reshape(count, width).all(axis=1), dtype=np.float64),
        whole=whole,
    )
