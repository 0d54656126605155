"""The drive's own scaling: what one count of position, velocity and torque is at the motor shaft."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drivers.errors import DriverError
from drivers.ethercat.sdo import SdoClient

_REVOLUTION = 2.0 * math.pi

ANGLE_UNITS: dict[int, float] = {
    0x10: 1.0,
    0x40: _REVOLUTION / 400.0,
    0x41: _REVOLUTION / 360.0,
    0x42: _REVOLUTION / 21_600.0,
    0x43: _REVOLUTION / 1_296_000.0,
    0xB4: _REVOLUTION,
}
"""Unit codes of angles in 0x60A8 and 0x60A9, rad (CiA 303-2): radian, gon, degree, minute, second of arc, turn."""
TIME_UNITS: dict[int, float] = {0x03: 1.0, 0x47: 60.0}
"""Unit codes of times in 0x60A9, s: second, minute."""
INCREMENT = 0xB5
"""Unit code of encoder increments, for which neither gear ratio nor feed constant applies."""


@dataclass(frozen=True, slots=True)
class DriveUnits:
    """Scales of a drive, all at the motor shaft and in the drive's own direction.

    Attributes
    ----------
    counts_per_turn : position counts a revolution of the motor shaft.
    velocity_rad_s : one count of velocity (0x606C, 0x60FF), rad/s.
    rated_torque_nm : rated torque (0x6076), N·m.
    rated_current_a : rated current (0x6075), A; None where the drive does not say.
    """

    counts_per_turn: float
    velocity_rad_s: float
    rated_torque_nm: float
    rated_current_a: float | None = None

    @property
    def position_rad(self) -> float:
        """One count of position (0x6064), rad."""
        return _REVOLUTION / self.counts_per_turn

    @property
    def torque_nm(self) -> float:
        """One count of torque (0x6071, 0x6077: a thousandth of the rated torque), N·m."""
        return self.rated_torque_nm * 1e-3


def read_units(sdo: SdoClient, velocity_rad_s: float | None = None) -> DriveUnits:
    """Read the drive's scaling objects.

    Parameters
    ----------
    velocity_rad_s : rad/s a count of velocity where the drive does not report it (or wrongly); None reads it.

    Raises
    ------
    DriverError
        Where an object is missing or holds what no scale can be made of, with what to configure instead.
    """
    gear = _ratio(sdo, 0x6091, default=1.0)
    counts = _counts_per_turn(sdo, gear)
    velocity = velocity_rad_s if velocity_rad_s is not None else _velocity(sdo, gear, counts)
    torque = sdo.read(0x6076, 0, "u4") * 1e-3
    if torque <= 0.0:
        raise DriverError(
            f"{sdo.name}: rated torque 6076:00 is 0; the drive's motor data should be set before it is used"
        )
    current = sdo.read(0x6075, 0, "u4") * 1e-3 if sdo.exists(0x6075, 0) else None
    return DriveUnits(counts, velocity, torque, current)


def _counts_per_turn(sdo: SdoClient, gear: float) -> float:
    """Position units a motor revolution: feed constant over gear ratio (CiA 402-2, 0x6092 and 0x6091).

    Where positions are in increments (0x60A8) or the drive has no feed constant it is the encoder's own resolution
    (0x608F).
    """
    in_increments = sdo.exists(0x60A8, 0) and sdo.read(0x60A8, 0, "u4") >> 16 & 0xFF == INCREMENT
    if sdo.exists(0x6092, 1) and not in_increments:
        return _ratio(sdo, 0x6092) / gear
    return _ratio(sdo, 0x608F)


def _velocity(sdo: SdoClient, gear: float, counts_per_turn: float) -> float:
    """One velocity count, rad/s: from unit code 0x60A9, or the velocity factor 0x6096 on position units a second."""
    unit = sdo.read(0x60A9, 0, "u4") if sdo.exists(0x60A9, 0) else 0
    angle, time = ANGLE_UNITS.get(unit >> 16 & 0xFF), TIME_UNITS.get(unit >> 8 & 0xFF)
    exponent = (unit >> 24 ^ 0x80) - 0x80
    if angle is not None and time is not None:
        return 10.0**exponent * angle / time * gear
    if unit >> 16 & 0xFF in (0, INCREMENT) and sdo.exists(0x6096, 1):
        return _REVOLUTION / counts_per_turn / _ratio(sdo, 0x6096)
    raise DriverError(
        f"{sdo.name}: the velocity unit 60A9:00 is 0x{unit:08X}, from which no rad/s follow; "
        "the scale should stand in the configuration"
    )


def _ratio(sdo: SdoClient, index: int, default: float | None = None) -> float:
    """Numerator (subindex 1) over denominator (2) of a scaling object."""
    if default is not None and not sdo.exists(index, 1):
        return default
    numerator, denominator = sdo.read(index, 1, "u4"), sdo.read(index, 2, "u4")
    if not numerator or not denominator:
        raise DriverError(
            f"{sdo.name}: scaling object {index:04X} is {numerator}/{denominator}; both parts should be above 0"
        )
    return numerator / denominator
