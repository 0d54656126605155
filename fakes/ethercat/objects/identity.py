"""Who a slave says it is: identity object, SII and ESI take it from here.

Masters copy mappings between slaves of equal vendor, product and revision, so devices that differ carry different
product codes. The vendor number belongs to no member of the EtherCAT Technology Group.
"""

from __future__ import annotations

from dataclasses import dataclass

VENDOR = 0xE0000B3C
VENDOR_NAME = "Emulated bench"
REVISION = 0x00010000

SERVO_FAMILY = 0x04020000
TORQUE_TERMINAL = 0x0A160102
TEMPERATURE_TERMINAL = 0x52540202
SAFETY_TERMINAL = 0x0D160802


@dataclass(frozen=True, slots=True)
class Identity:
    """Vendor, product, revision and serial number (0x1018), and the strings of 0x1008-0x100A.

    ``order`` is the short type name of SII and ESI, ``profile`` the device profile of 0x1000.
    """

    product: int
    serial: int
    order: str
    name: str
    profile: int
    vendor: int = VENDOR
    revision: int = REVISION
    hardware: str = "1"
    software: str = "1.0"


def servo_product(encoder_bits: int, axis: int) -> int:
    """Return the product code of a servo drive: one for each encoder and axis (1 input, 2 load)."""
    return SERVO_FAMILY | encoder_bits << 8 | axis
