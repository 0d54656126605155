"""From the plant's SI values to the units of a drive's objects and back, as the object dictionary sets them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from fakes.ethercat.drive.objects import DriveData, velocity_unit_rad_s
from fakes.ethercat.objects.dictionary import ObjectDictionary

OVERSPEED = 1.2
"""Part of the maximum speed above which a drive trips."""

Floats: TypeAlias = npt.NDArray[np.float64] | float

_RPM = 2.0 * math.pi / 60.0
_INT32 = (-(2**31), 2**31 - 1)
_INT16 = (-(2**15), 2**15 - 1)
_POSITION_REVERSED, _VELOCITY_REVERSED, _TORQUE_REVERSED = 0x80, 0x40, 0x20
"""0x607E: bits 7 and 6 are the standard's, bit 5 reverses torque likewise."""


def clip(values: Any, low: float, high: float) -> Any:
    """Limit a number or rows; two ufuncs are faster than ``np.clip``."""
    return np.minimum(np.maximum(values, low), high)


@dataclass(frozen=True, slots=True)
class Scaling:
    """Signed units (rad/s and N·m in one unit of velocity and torque objects) and the limits the drive keeps."""

    velocity_unit: float
    torque_unit: float
    position_sign: int
    home_offset: int
    top_rad_s: float
    trip_rad_s: float
    torque_low: int
    torque_high: int

    @classmethod
    def of(cls, dictionary: ObjectDictionary, drive: DriveData) -> Scaling:
        """Read the settings of a drive."""
        value = dictionary.integer
        polarity, limit = value(0x607E), value(0x6072)
        velocity_unit = velocity_unit_rad_s(drive.velocity_unit)
        torque_unit = drive.rated_torque_n_m / 1000.0
        return cls(
            velocity_unit=-velocity_unit if polarity & _VELOCITY_REVERSED else velocity_unit,
            torque_unit=-torque_unit if polarity & _TORQUE_REVERSED else torque_unit,
            position_sign=-1 if polarity & _POSITION_REVERSED else 1,
            home_offset=value(0x607C),
            top_rad_s=min(value(0x6080) * _RPM, value(0x607F) * velocity_unit),
            trip_rad_s=OVERSPEED * drive.maximum_speed_rpm * _RPM,
            torque_low=-min(limit, value(0x60E1)),
            torque_high=min(limit, value(0x60E0)),
        )

    def velocity_command(self, units: Floats) -> Floats:
        """Return rad/s for 0x60FF, within the maximum speed."""
        limited: Floats = clip(units * self.velocity_unit, -self.top_rad_s, self.top_rad_s)
        return limited

    def torque_command(self, permille: Floats) -> Floats:
        """Return N·m for 0x6071, within the torque limits."""
        limited: Floats = clip(permille, self.torque_low, self.torque_high) * self.torque_unit
        return limited

    def position(self, counts: npt.NDArray[np.int64]) -> npt.NDArray[np.int32]:
        """Return 0x6064 for encoder counts; it overflows as an INTEGER32 does."""
        wrapped: npt.NDArray[np.int32] = ((counts + self.home_offset) * self.position_sign).astype(np.int32)
        return wrapped

    def velocity(self, rad_s: npt.NDArray[np.float64]) -> npt.NDArray[np.int32]:
        """Return 0x606C for rad/s."""
        units: npt.NDArray[np.int32] = clip(np.rint(rad_s / self.velocity_unit), *_INT32).astype(np.int32)
        return units

    def torque(self, newton_metres: npt.NDArray[np.float64]) -> npt.NDArray[np.int16]:
        """Return 0x6077 in thousandths of the rated torque for N·m."""
        permille: npt.NDArray[np.int16] = clip(np.rint(newton_metres / self.torque_unit), *_INT16).astype(np.int16)
        return permille

    def at_torque_limit(self, permille: npt.NDArray[np.int16]) -> npt.NDArray[np.bool_]:
        """Return where a torque stands at its limit."""
        limited: npt.NDArray[np.bool_] = (permille <= self.torque_low) | (permille >= self.torque_high)
        return limited
