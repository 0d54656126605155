"""PDO assignment and mapping (0x1C12/0x1C13, 0x16xx/0x1Axx) and the process image that follows from them.

Source: ETG.1000.6 §5.6.7.4.7-9. Entries are byte-aligned here; a mapping entry with index 0 is padding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from fakes.ethercat.objects import aborts
from fakes.ethercat.objects.aborts import SdoAbort
from fakes.ethercat.objects.dictionary import ObjectDictionary, key
from fakes.ethercat.objects.types import Value

RX_ASSIGN, TX_ASSIGN = 0x1C12, 0x1C13
_DIRECTION = {RX_ASSIGN: (0x1600, "r"), TX_ASSIGN: (0x1A00, "t")}
_Check: TypeAlias = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Layout:
    """One direction of a slave's process image: its packed fields, named as ``6040:00``."""

    dtype: np.dtype[np.void]

    @property
    def size(self) -> int:
        """Length in bytes."""
        return int(self.dtype.itemsize)

    @property
    def names(self) -> tuple[str, ...]:
        """Mapped entries in order."""
        return self.dtype.names or ()

    def slices(self) -> tuple[tuple[int, int, int], ...]:
        """Return (dictionary key, first byte, stop byte) of every field."""
        found = []
        for name in self.names:
            dtype, at = self.dtype.fields[name][:2] if self.dtype.fields else (self.dtype, 0)
            found.append((key(int(name[:4], 16), int(name[5:], 16)), at, at + dtype.itemsize))
        return tuple(found)


def mapping_word(index: int, subindex: int, bits: int) -> int:
    """Return the UDINT by which a mapping object names an entry."""
    return index << 16 | subindex << 8 | bits


class PdoConfiguration:
    """Checks what is written to assignment and mapping objects and derives the process image."""

    def __init__(self, dictionary: ObjectDictionary) -> None:
        self._dictionary = dictionary
        for index in dictionary.objects:
            if 0x1600 <= index <= 0x17FF or 0x1A00 <= index <= 0x1BFF:
                self._guard(index, self._check_mapping)
            elif index in _DIRECTION:
                self._guard(index, self._check_assignment)

    def layout(self, assignment: int) -> Layout:
        """Return the process image of one direction (``RX_ASSIGN`` or ``TX_ASSIGN``)."""
        names: list[str] = []
        formats: list[str] = []
        offsets: list[int] = []
        bits = 0
        for word in self._mapped(assignment):
            index, subindex, width = word >> 16, word >> 8 & 0xFF, word & 0xFF
            if index:
                names.append(f"{index:04X}:{subindex:02X}")
                formats.append(self._dictionary.entry(index, subindex).type.dtype)
                offsets.append(bits // 8)
            bits += width
        return Layout(np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": bits // 8}))

    def _mapped(self, assignment: int) -> list[int]:
        d = self._dictionary
        if assignment not in d.objects:
            return []
        pdos = [d.integer(assignment, sub) for sub in range(1, d.integer(assignment) + 1)]
        return [d.integer(pdo, sub) for pdo in pdos for sub in range(1, d.integer(pdo) + 1)]

    def _guard(self, index: int, check: _Check) -> None:
        """Entries may change only while subindex 0 is 0; setting it validates the whole."""
        d = self._dictionary

        def resize(value: Value) -> None:
            assert isinstance(value, int)
            for sub in range(1, value + 1):
                check(index, d.integer(index, sub))

        def replace(_: Value) -> None:
            if d.integer(index) != 0:
                raise SdoAbort(aborts.SUBINDEX_ZERO)

        for sub in d.objects[index].entries:
            d.writers[key(index, sub)] = replace if sub else resize

    def _check_assignment(self, index: int, value: int) -> None:
        first, _ = _DIRECTION[index]
        if not first <= value <= first + 0x1FF or value not in self._dictionary.objects:
            raise SdoAbort(aborts.RANGE)

    def _check_mapping(self, index: int, word: int) -> None:
        mapped, subindex, width = word >> 16, word >> 8 & 0xFF, word & 0xFF
        if width % 8 or width == 0:
            raise SdoAbort(aborts.NOT_MAPPABLE)
        if mapped == 0:
            return
        entry = self._dictionary.entry(mapped, subindex)
        if ("t" if index >= 0x1A00 else "r") not in entry.pdo or entry.bits != width:
            raise SdoAbort(aborts.NOT_MAPPABLE)
