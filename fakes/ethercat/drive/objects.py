"""Objects of a CiA 402 servo drive (IEC 61800-7-201, CiA 402-2) in CSV and CST, as data.

Limits of writable entries are those the drive enforces. What the drive measures is read through readers and has no
stored value of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from fakes.ethercat.drive.cia402 import SUPPORTED_MODES, Mode
from fakes.ethercat.objects.common import assignments, mapping
from fakes.ethercat.objects.dictionary import Entry, Object, record, variable
from fakes.ethercat.objects.types import DINT, INT, SINT, UDINT, UINT, USINT

PROFILE_SERVO = 0x00020192
"""0x1000 of a servo drive: profile 402, type 2."""

RPM = 0x00B44700
"""0x60A9: revolutions (0xB4) a minute (0x47); the top byte is the power of ten, signed."""


def velocity_unit_rad_s(code: int) -> float:
    """Return rad/s in one unit of an 0x60A9 code counting revolutions a minute."""
    exponent = code >> 24
    exponent -= 256 if exponent > 127 else 0
    return 2.0 * math.pi / 60.0 * float(10.0**exponent)


@dataclass(frozen=True, slots=True)
class DriveData:
    """What sets one drive apart: its motor, encoder and units.

    ``rated_torque_n_m``, ``maximum_torque_n_m`` at the shaft; ``maximum_speed_rpm`` trips the drive above;
    ``velocity_unit`` an 0x60A9 code; ``axis`` 1 input, 2 load; ``mode`` the mode after power-on.
    """

    axis: int
    encoder_bits: int
    rated_torque_n_m: float
    maximum_torque_n_m: float
    maximum_speed_rpm: int
    velocity_unit: int
    mode: Mode

    @property
    def counts(self) -> int:
        """Encoder counts a revolution."""
        return 1 << self.encoder_bits


RX_DEFAULT = ((0x6040, 0, 16), (0x60FF, 0, 32), (0x6071, 0, 16), (0x6060, 0, 8))
TX_DEFAULT = ((0x6041, 0, 16), (0x6064, 0, 32), (0x606C, 0, 32), (0x6077, 0, 16), (0x6061, 0, 8), (0x603F, 0, 16))

PERMANENT_MAGNET = 10
"""0x6402: sinusoidal permanent-magnet synchronous motor."""

OPTION_CODES = ((0x605A, "Quick stop", 2), (0x605B, "Shutdown", 0), (0x605C, "Disable operation", 1))


def servo_objects(drive: DriveData) -> tuple[Object, ...]:
    """Return the objects a servo drive has beyond the common ones."""
    permille = round(1000.0 * drive.maximum_torque_n_m / drive.rated_torque_n_m)
    unit = velocity_unit_rad_s(drive.velocity_unit)
    top = round(drive.maximum_speed_rpm * velocity_unit_rad_s(RPM) / unit)
    return (
        mapping(0x1600, "RxPDO mapping", RX_DEFAULT, "rwpre"),
        mapping(0x1601, "RxPDO mapping", ((0x6040, 0, 16), (0x6071, 0, 16)), "rwpre"),
        mapping(0x1A00, "TxPDO mapping", TX_DEFAULT, "rwpre"),
        mapping(0x1A01, "TxPDO mapping", ((0x6041, 0, 16), (0x6064, 0, 32)), "rwpre"),
        *assignments((0x1600,), (0x1A00,), "rwpre"),
        variable(0x603F, "Error code", UINT, "ro", 0, "t"),
        variable(0x6040, "Controlword", UINT, "rw", 0, "r"),
        variable(0x6041, "Statusword", UINT, "ro", 0, "t"),
        *(variable(i, f"{name} option code", INT, "rw", value, "", 0, 7) for i, name, value in OPTION_CODES),
        variable(0x605D, "Halt option code", INT, "rw", 1, "", 1, 4),
        variable(0x605E, "Fault reaction option code", INT, "rw", 2, "", 0, 4),
        variable(0x6060, "Modes of operation", SINT, "rw", int(drive.mode), "r", 0, 10),
        variable(0x6061, "Modes of operation display", SINT, "ro", int(drive.mode), "t"),
        variable(0x6062, "Position demand value", DINT, "ro", 0, "t"),
        variable(0x6063, "Position actual internal value", DINT, "ro", 0, "t"),
        variable(0x6064, "Position actual value", DINT, "ro", 0, "t"),
        variable(0x6065, "Following error window", UDINT, "rw", drive.counts // 8),
        variable(0x6066, "Following error time out", UINT, "rw", 10),
        variable(0x6067, "Position window", UDINT, "rw", 10),
        variable(0x606B, "Velocity demand value", DINT, "ro", 0, "t"),
        variable(0x606C, "Velocity actual value", DINT, "ro", 0, "t"),
        variable(0x6071, "Target torque", INT, "rw", 0, "r"),
        variable(0x6072, "Max torque", UINT, "rw", permille, "r", 0, permille),
        variable(0x6073, "Max current", UINT, "rw", permille, "r", 0, permille),
        variable(0x6074, "Torque demand value", INT, "ro", 0, "t"),
        variable(0x6075, "Motor rated current", UDINT, "ro", round(1000.0 * drive.rated_torque_n_m)),
        variable(0x6076, "Motor rated torque", UDINT, "ro", round(1000.0 * drive.rated_torque_n_m)),
        variable(0x6077, "Torque actual value", INT, "ro", 0, "t"),
        variable(0x6078, "Current actual value", INT, "ro", 0, "t"),
        variable(0x6079, "DC link circuit voltage", UDINT, "ro", 565_000, "t"),
        variable(0x607A, "Target position", DINT, "rw", 0, "r"),
        variable(0x607C, "Home offset", DINT, "rw", 0),
        variable(0x607E, "Polarity", USINT, "rw", 0),
        variable(0x607F, "Max profile velocity", UDINT, "rw", top, "", 0, top),
        variable(0x6080, "Max motor speed", UDINT, "rw", drive.maximum_speed_rpm, "", 0, drive.maximum_speed_rpm),
        variable(0x6085, "Quick stop deceleration", UDINT, "rw", 2 * top),
        _ratio(0x608F, "Position encoder resolution", "Encoder increments", drive.counts, "Motor revolutions", "ro"),
        _ratio(0x6091, "Gear ratio", "Motor revolutions", 1, "Shaft revolutions", "ro"),
        _ratio(0x6092, "Feed constant", "Feed", drive.counts, "Shaft revolutions", "ro"),
        _ratio(0x6096, "Velocity factor", "Numerator", 1, "Divisor", "ro"),
        variable(0x60A9, "SI unit velocity", UDINT, "ro", drive.velocity_unit),
        variable(0x60B0, "Position offset", DINT, "rw", 0, "r"),
        variable(0x60B1, "Velocity offset", DINT, "rw", 0, "r"),
        variable(0x60B2, "Torque offset", INT, "rw", 0, "r"),
        record(
            0x60C2,
            "Interpolation time period",
            Entry("Interpolation time period value", USINT, "rw", 5, "", 1, 255),
            Entry("Interpolation time index", SINT, "rw", -4, "", -6, 0),
        ),
        variable(0x60E0, "Positive torque limit value", UINT, "rw", permille, "r", 0, permille),
        variable(0x60E1, "Negative torque limit value", UINT, "rw", permille, "r", 0, permille),
        variable(0x60F4, "Following error actual value", DINT, "ro", 0, "t"),
        variable(0x60FD, "Digital inputs", UDINT, "ro", 0, "t"),
        record(
            0x60FE,
            "Digital outputs",
            Entry("Physical outputs", UDINT, "rw", 0, "r"),
            Entry("Bit mask", UDINT, "rw", 0),
        ),
        variable(0x60FF, "Target velocity", DINT, "rw", 0, "r"),
        variable(0x6402, "Motor type", UINT, "ro", PERMANENT_MAGNET),
        variable(0x6502, "Supported drive modes", UDINT, "ro", SUPPORTED_MODES),
    )


def _ratio(index: int, name: str, first: str, value: int, second: str, access: str) -> Object:
    return record(index, name, Entry(first, UDINT, access, value, "", 1), Entry(second, UDINT, access, 1, "", 1))
