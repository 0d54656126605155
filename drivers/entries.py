"""Entries of process data: objects by index, with their type, packed as they travel on the wire."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike

from drivers.errors import DriverError

TYPES: dict[str, str] = {
    "u1": "<u1",
    "i1": "<i1",
    "u2": "<u2",
    "i2": "<i2",
    "u4": "<u4",
    "i4": "<i4",
    "u8": "<u8",
    "i8": "<i8",
    "f4": "<f4",
    "f8": "<f8",
}
"""Types of entries: kind (unsigned, integer, float) and bytes; EtherCAT is little endian throughout."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One object in process data.

    Parameters
    ----------
    name : ``index:subindex`` in hexadecimal, such as ``"6064:00"``.
    type : key of :data:`TYPES`.

    Raises
    ------
    DriverError
        If the name is no object address or the type is unknown.
    """

    name: str
    type: str

    def __post_init__(self) -> None:
        """Refuse a malformed address or type here, where the sentence can still name the entry."""
        if self.type not in TYPES:
            raise DriverError(
                f"entry '{self.name}' has the unknown type '{self.type}'; one of {', '.join(TYPES)} is right"
            )
        index, subindex = _address(self.name)
        if self.name != entry_name(index, subindex):
            raise DriverError(f"entry '{self.name}' should be written '{entry_name(index, subindex)}'")

    @property
    def index(self) -> int:
        """Object index."""
        return _address(self.name)[0]

    @property
    def subindex(self) -> int:
        """Object subindex."""
        return _address(self.name)[1]

    @property
    def bytes(self) -> int:
        """Size in the process image, bytes."""
        return int(self.type[1:])

    @property
    def mapping(self) -> int:
        """Mapping word as in 0x16xx and 0x1Axx: index (16 bit), subindex (8 bit), length in bits (8 bit)."""
        return self.index << 16 | self.subindex << 8 | 8 * self.bytes


def entry_name(index: int, subindex: int) -> str:
    """Name of an entry: four and two upper-case hexadecimal digits."""
    return f"{index:04X}:{subindex:02X}"


def _address(name: str) -> tuple[int, int]:
    index, colon, subindex = name.partition(":")
    try:
        address = int(index, 16), int(subindex, 16)
    except ValueError:
        address = -1, -1
    if not colon or not (0 <= address[0] <= 0xFFFF and 0 <= address[1] <= 0xFF):
        raise DriverError(
            f"entry '{name}' is no object address; 'index:subindex' in hexadecimal is right, as '6064:00'"
        )
    return address


def entries_dtype(entries: Iterable[Entry]) -> np.dtype[np.void]:
    """Structured type of a slave's image, little endian and packed exactly as on the wire.

    Raises
    ------
    DriverError
        If an entry stands twice.
    """
    fields: list[tuple[str, DTypeLike]] = []
    seen: set[str] = set()
    for entry in entries:
        if entry.name in seen:
            raise DriverError(f"entry '{entry.name}' is mapped twice; each object may stand once in a process image")
        seen.add(entry.name)
        fields.append((entry.name, TYPES[entry.type]))
    return np.dtype(fields)
