"""CoE basic data types (ETG.1000.6 §5.6.7, CiA 301 §7.4.7): codes, widths and little-endian coding."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import TypeAlias

Value: TypeAlias = int | float | bytes


@dataclass(frozen=True, slots=True)
class DataType:
    """One basic data type.

    ``code`` is its index in the dictionary, ``bits`` its width (0 for strings: as long as the value), ``fmt`` the
    :mod:`struct` letter (empty for strings) and ``dtype`` the NumPy name used in the process image.
    """

    name: str
    code: int
    bits: int
    fmt: str
    dtype: str

    def encode(self, value: Value) -> bytes:
        """Return the little-endian bytes of a value; strings are given as bytes."""
        if not self.fmt:
            assert isinstance(value, bytes)
            return value
        return struct.pack("<" + self.fmt, value)

    def decode(self, data: bytes) -> Value:
        """Return the value of little-endian bytes; strings stay bytes."""
        if not self.fmt:
            return data
        value: Value = struct.unpack("<" + self.fmt, data)[0]
        return value


BOOL = DataType("BOOL", 0x0001, 8, "B", "<u1")
SINT = DataType("SINT", 0x0002, 8, "b", "<i1")
INT = DataType("INT", 0x0003, 16, "h", "<i2")
DINT = DataType("DINT", 0x0004, 32, "i", "<i4")
USINT = DataType("USINT", 0x0005, 8, "B", "<u1")
UINT = DataType("UINT", 0x0006, 16, "H", "<u2")
UDINT = DataType("UDINT", 0x0007, 32, "I", "<u4")
REAL = DataType("REAL", 0x0008, 32, "f", "<f4")
STRING = DataType("STRING", 0x0009, 0, "", "S")
OCTETS = DataType("OCTET_STRING", 0x000A, 0, "", "S")
LINT = DataType("LINT", 0x0015, 64, "q", "<i8")
ULINT = DataType("ULINT", 0x001B, 64, "Q", "<u8")
