"""Error codes a drive puts into 0x603F and emergency messages (CiA 402-1, table of error codes)."""

from __future__ import annotations

CONTINUOUS_OVER_CURRENT = 0x2310
SHORT_CIRCUIT = 0x2340
DC_LINK_OVER_VOLTAGE = 0x3210
DC_LINK_UNDER_VOLTAGE = 0x3220
DEVICE_TEMPERATURE = 0x4210
MOTOR_TEMPERATURE = 0x4310
SENSOR = 0x7300
SPEED_SENSOR = 0x7310
COMMUNICATION = 0x7500
MOTOR_BLOCKED = 0x7121
VELOCITY_CONTROL = 0x8400
FOLLOWING_ERROR = 0x8611

_REGISTER_BITS: tuple[tuple[int, int, int], ...] = (
    (0x2000, 0x2FFF, 0x02),
    (0x3000, 0x3FFF, 0x04),
    (0x4000, 0x4FFF, 0x08),
    (0x8100, 0x81FF, 0x10),
    (0x7500, 0x75FF, 0x10),
    (0x8400, 0x86FF, 0x20),
)


def error_register(code: int) -> int:
    """Return 0x1001: bit 0 any, 1 current, 2 voltage, 3 temperature, 4 communication, 5 profile."""
    if code == 0:
        return 0
    return 0x01 | sum(bit for low, high, bit in _REGISTER_BITS if low <= code <= high)
