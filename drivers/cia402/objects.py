"""Objects of CiA 402 that can be process data, with their types, and the maps used where none is configured."""

from __future__ import annotations

from collections.abc import Iterable

from drivers.entries import Entry
from drivers.errors import DriverError

TYPES: dict[str, str] = {
    "6040:00": "u2",
    "6060:00": "i1",
    "6071:00": "i2",
    "6072:00": "u2",
    "607A:00": "i4",
    "60B1:00": "i4",
    "60B2:00": "i2",
    "60B8:00": "u2",
    "60E0:00": "u2",
    "60E1:00": "u2",
    "60FE:01": "u4",
    "60FF:00": "i4",
    "603F:00": "u2",
    "6041:00": "u2",
    "6061:00": "i1",
    "6062:00": "i4",
    "6064:00": "i4",
    "606B:00": "i4",
    "606C:00": "i4",
    "6074:00": "i2",
    "6077:00": "i2",
    "6078:00": "i2",
    "6079:00": "u4",
    "60B9:00": "u2",
    "60BA:00": "i4",
    "60F4:00": "i4",
    "60FD:00": "u4",
}
"""Type by entry: control and set values first, then status and actual values."""

DEFAULT_OUTPUTS = ("6040:00", "60FF:00", "6071:00", "6060:00")
DEFAULT_INPUTS = ("6041:00", "6064:00", "606C:00", "6077:00", "6061:00", "603F:00")


def entries(names: Iterable[str]) -> tuple[Entry, ...]:
    """Entries by name; an object of the maker's is written with its type, as ``"2010:01/i4"``.

    Raises
    ------
    DriverError
        If the type of an object is neither given nor known.
    """
    result = []
    for name in names:
        address, _, given = name.partition("/")
        type_ = given or TYPES.get(address)
        if type_ is None:
            raise DriverError(f"the type of process data entry '{name}' is not known; write it as '{address}/i4'")
        result.append(Entry(address, type_))
    return tuple(result)
