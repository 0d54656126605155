"""The torque sensor's zero from readings at rest without load; refuses a dead, saturated, moving or loaded sensor."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from bench.configuration import BenchConfiguration
from bench.cycle.assembly import device_errors
from bench.cycle.plugins import DRIVERS, plugin

_SHARE_OF_RATED, _SPREAD_OF_RATED = 0.01, 0.001


@dataclass(frozen=True, slots=True)
class TorqueZero:
    """What the unloaded sensor reads, N·m: mean and standard deviation of so many readings."""

    zero: float
    deviation: float
    readings: int


def torque_zero(bench: BenchConfiguration, volt_per_count: float, counts: NDArray[np.int16]) -> TorqueZero:
    """Return the zero of raw readings (n,) of the sensor's terminal.

    Raises
    ------
    DeviceError
        If they are no zero: out of range, frozen, scattered, or too large.
    """
    sensor = bench.torque_sensor
    with device_errors():
        scale = plugin(DRIVERS, "torque_scale")(
            volt_per_count, sensor.rated_torque / sensor.rated_voltage, sensor.polarity
        )
        taken = plugin(DRIVERS, "torque_tare")(
            counts,
            np.abs(counts.astype(np.int32)) < np.iinfo(np.int16).max,
            scale,
            datetime.now(UTC),
            bench.commissioning.largest_tare or _SHARE_OF_RATED * sensor.rated_torque,
            _SPREAD_OF_RATED * sensor.rated_torque,
        )
    unit = float(scale.newton_metre_per_count)
    return TorqueZero(float(taken.zero_count) * unit, abs(float(taken.deviation_count) * unit), int(counts.size))
