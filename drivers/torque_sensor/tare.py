"""Taring: the reading without torque, before and after a campaign, and how far it drifted in between."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from drivers.errors import SensorError
from drivers.torque_sensor.scale import TorqueScale


@dataclass(frozen=True, slots=True)
class Tare:
    """Reading of the unloaded sensor.

    Attributes
    ----------
    zero_count : mean reading, counts.
    deviation_count : standard deviation of one reading, counts.
    samples : readings that went into it.
    taken_at : when.
    temperature_c : lubricant temperature at that time, °C; NaN where unknown.
    """

    zero_count: float
    deviation_count: float
    samples: int
    taken_at: datetime
    temperature_c: float = float("nan")


@dataclass(frozen=True, slots=True)
class Drift:
    """Difference of two tares.

    Attributes
    ----------
    torque_nm : later minus earlier zero, N·m in the bench's sign.
    fraction : the same, over the sensor's rated torque.
    duration_s : time between them.
    """

    torque_nm: float
    fraction: float
    duration_s: float


def take_tare(
    counts: NDArray[np.integer],
    usable: NDArray[np.bool_],
    scale: TorqueScale,
    taken_at: datetime,
    largest_zero_nm: float,
    largest_spread_nm: float,
    temperature_c: float = float("nan"),
    name: str = "torque sensor",
) -> Tare:
    """Tare on a stretch of readings at rest, without torque.

    Parameters
    ----------
    counts, usable : readings (n,) and which of them count.
    scale : measuring chain; its zero is not used.
    largest_zero_nm : a larger zero is no zero: something loads the sensor, or a wire is broken, N·m.
    largest_spread_nm : standard deviation above which the bench is not at rest, N·m.

    Raises
    ------
    SensorError
        If a reading is unusable, the readings never change (a frozen terminal), or the zero or its spread is too large.
    """
    if len(counts) < 2 or not usable.all():
        raise SensorError(
            f"{name}: {int((~usable).sum())} of {len(counts)} readings for taring are out of range or in error; "
            "check sensor supply and wiring"
        )
    unit = abs(scale.newton_metre_per_count)
    mean, deviation = float(np.mean(counts)), float(np.std(counts))
    if np.ptp(counts) == 0 and mean in (0.0, float(np.iinfo(counts.dtype).max), float(np.iinfo(counts.dtype).min)):
        raise SensorError(
            f"{name}: every reading for taring is exactly {mean:g} counts; check the wire to the terminal"
        )
    if deviation * unit > largest_spread_nm:
        raise SensorError(
            f"{name}: readings for taring scatter by {deviation * unit:.3g} N·m where {largest_spread_nm:.3g} N·m are "
            "allowed; taring needs the bench at rest"
        )
    if abs(mean) * unit > largest_zero_nm:
        raise SensorError(
            f"{name}: the zero is {mean * scale.newton_metre_per_count:.4g} N·m where {largest_zero_nm:.3g} N·m are "
            "allowed; take the load off, or check the sensor"
        )
    return Tare(mean, deviation, len(counts), taken_at, temperature_c)


def drift(before: Tare, after: Tare, scale: TorqueScale, rated_torque_nm: float) -> Drift:
    """Return how far the zero moved between two tares."""
    torque = (after.zero_count - before.zero_count) * scale.newton_metre_per_count
    return Drift(torque, torque / rated_torque_nm, (after.taken_at - before.taken_at).total_seconds())
