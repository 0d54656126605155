"""Modes of operation (0x6060, 0x6061) and which of them a drive supports (0x6502)."""

from __future__ import annotations

from enum import IntEnum


class Mode(IntEnum):
    """Modes of CiA 402-2, table 54."""

    NONE = 0
    PROFILE_POSITION = 1
    VELOCITY = 2
    PROFILE_VELOCITY = 3
    PROFILE_TORQUE = 4
    HOMING = 6
    INTERPOLATED_POSITION = 7
    CYCLIC_SYNCHRONOUS_POSITION = 8
    CYCLIC_SYNCHRONOUS_VELOCITY = 9
    CYCLIC_SYNCHRONOUS_TORQUE = 10

    @property
    def text(self) -> str:
        """Name in words."""
        return self.name.lower().replace("_", " ")

    @property
    def support_bit(self) -> int:
        """Bit of this mode in "supported drive modes" (0x6502); 0 for no mode."""
        return 1 << (self - 1) if self > 0 else 0


CSV = Mode.CYCLIC_SYNCHRONOUS_VELOCITY
CST = Mode.CYCLIC_SYNCHRONOUS_TORQUE

SET_VALUE: dict[Mode, str] = {CSV: "60FF:00", CST: "6071:00"}
"""Entry of the set value of each cyclic mode the bench uses: target velocity, target torque."""
