"""The object dictionary of a slave: objects as data, values as bytes, access rules as the standard has them.

Source: ETG.1000.6 §5.6 (CoE), CiA 301 §7.4. Values are kept in one flat table, so that a snapshot of a slave is one
dictionary copy. Objects whose value lives elsewhere (a status word, a position) are read through ``readers``; objects
whose value must be checked or acted upon pass through ``writers``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from fakes.ethercat.objects import aborts
from fakes.ethercat.objects.aborts import SdoAbort
from fakes.ethercat.objects.types import USINT, DataType, Value

VARIABLE, ARRAY, RECORD = 7, 8, 9
"""Object codes (ETG.1000.6 table 62)."""

PRE_OP = 0x02


@dataclass(frozen=True, slots=True)
class Entry:
    """One subindex of an object.

    ``access`` is ``ro``, ``rw``, ``wo`` or ``rwpre`` (writable in PRE-OPERATIONAL only); ``pdo`` holds ``r`` where
    the entry may stand in an RxPDO and ``t`` where in a TxPDO; ``low`` and ``high`` bound what may be written.
    """

    name: str
    type: DataType
    access: str = "ro"
    default: Value = 0
    pdo: str = ""
    low: float | None = None
    high: float | None = None

    @property
    def bits(self) -> int:
        """Width in bits; that of a string is its default's."""
        return self.type.bits or 8 * len(self.type.encode(self.default))

    @property
    def access_flags(self) -> int:
        """Object access word of the SDO information service (ETG.1000.6 §5.6.3.6.2)."""
        reading = 0x00 if self.access == "wo" else 0x07
        writing = {"rw": 0x38, "wo": 0x38, "rwpre": 0x08}.get(self.access, 0x00)
        return reading | writing | (0x40 if "r" in self.pdo else 0) | (0x80 if "t" in self.pdo else 0)


@dataclass(frozen=True, slots=True)
class Object:
    """One index: its name, object code and entries by subindex."""

    index: int
    name: str
    code: int
    entries: dict[int, Entry]


def variable(
    index: int,
    name: str,
    type_: DataType,
    access: str = "ro",
    default: Value = 0,
    pdo: str = "",
    low: float | None = None,
    high: float | None = None,
) -> Object:
    """Return an object of one entry."""
    return Object(index, name, VARIABLE, {0: Entry(name, type_, access, default, pdo, low, high)})


def record(index: int, name: str, *entries: Entry) -> Object:
    """Return a record with subindex 0 (the number of entries, fixed) and the given entries from subindex 1."""
    return sparse_record(index, name, dict(enumerate(entries, start=1)))


def sparse_record(index: int, name: str, entries: dict[int, Entry]) -> Object:
    """Return a record whose subindices have gaps; subindex 0 holds the highest."""
    count = Entry("Number of entries", USINT, "ro", max(entries))
    return Object(index, name, RECORD, {0: count, **entries})


def array(index: int, name: str, type_: DataType, values: Iterable[Value], access: str, capacity: int = 0) -> Object:
    """Return an array whose length may change if it is writable (``capacity`` subindices, subindex 0 writable)."""
    given = list(values)
    count = Entry("Number of entries", USINT, access, len(given), "", 0, max(capacity, len(given)))
    filled = given + [type_.decode(bytes(type_.bits // 8))] * (max(capacity, len(given)) - len(given))
    entries = {i: Entry(f"{name} {i:03d}", type_, access, v) for i, v in enumerate(filled, start=1)}
    return Object(index, name, ARRAY, {0: count, **entries})


def key(index: int, subindex: int) -> int:
    """Return the flat key of an entry."""
    return index << 8 | subindex


class ObjectDictionary:
    """Objects of one slave and their values."""

    def __init__(self, objects: Iterable[Object]) -> None:
        self.objects: dict[int, Object] = {o.index: o for o in sorted(objects, key=lambda o: o.index)}
        self.readers: dict[int, Callable[[], Value]] = {}
        self.writers: dict[int, Callable[[Value], None]] = {}
        self.values: dict[int, bytes] = {}
        self.version = 0
        """Counts changes of settings, so that who derives something from them knows when to do it anew."""
        self.reset()

    def reset(self) -> None:
        """Bring every value back to its default, as after power-on."""
        self.version += 1
        self.values = {
            key(o.index, sub): entry.type.encode(entry.default)
            for o in self.objects.values()
            for sub, entry in o.entries.items()
        }

    def entry(self, index: int, subindex: int) -> Entry:
        """Return an entry; raises :class:`SdoAbort` where there is none."""
        found = self.objects.get(index)
        if found is None:
            raise SdoAbort(aborts.NO_OBJECT)
        if subindex not in found.entries:
            raise SdoAbort(aborts.NO_SUBINDEX)
        return found.entries[subindex]

    def value(self, index: int, subindex: int = 0) -> Value:
        """Return the decoded value of an entry, whatever its access."""
        entry = self.entry(index, subindex)
        reader = self.readers.get(key(index, subindex))
        return reader() if reader else entry.type.decode(self.values[key(index, subindex)])

    def integer(self, index: int, subindex: int = 0) -> int:
        """Return the value of an integer entry."""
        value = self.value(index, subindex)
        assert isinstance(value, int)
        return value

    def store(self, index: int, subindex: int, value: Value) -> None:
        """Set a value from inside the device: no access rule, no writer."""
        self.values[key(index, subindex)] = self.entry(index, subindex).type.encode(value)
        self.version += 1

    def read(self, index: int, subindex: int) -> bytes:
        """Return the bytes of an entry as an SDO upload gives them."""
        entry = self.entry(index, subindex)
        if entry.access == "wo":
            raise SdoAbort(aborts.WRITE_ONLY)
        return entry.type.encode(self.value(index, subindex))

    def write(self, index: int, subindex: int, data: bytes, state: int = PRE_OP) -> None:
        """Take the bytes of an SDO download; ``state`` is the AL state of the slave."""
        entry = self.entry(index, subindex)
        if entry.access == "ro":
            raise SdoAbort(aborts.READ_ONLY)
        if entry.access == "rwpre" and state != PRE_OP:
            raise SdoAbort(aborts.WRONG_STATE)
        if entry.type.bits and len(data) * 8 != entry.type.bits:
            raise SdoAbort(aborts.TOO_LONG if len(data) * 8 > entry.type.bits else aborts.TOO_SHORT)
        value = entry.type.decode(data)
        if not isinstance(value, bytes):
            if entry.high is not None and value > entry.high:
                raise SdoAbort(aborts.TOO_HIGH)
            if entry.low is not None and value < entry.low:
                raise SdoAbort(aborts.TOO_LOW)
        writer = self.writers.get(key(index, subindex))
        if writer:
            writer(value)
        self.values[key(index, subindex)] = data
        self.version += 1

    def read_complete(self, index: int, subindex: int) -> bytes:
        """Return a whole object: subindex 0 widened to 16 bit, then the entries it counts (complete access)."""
        found = self._whole(index, subindex)
        last = self.integer(index, 0)
        parts = [self.read(index, sub) for sub in sorted(found.entries) if 1 <= sub <= last]
        return (self.read(index, 0).ljust(2, b"\0") if subindex == 0 else b"") + b"".join(parts)

    def write_complete(self, index: int, subindex: int, data: bytes, state: int = PRE_OP) -> None:
        """Take a whole object. A writable subindex 0 is cleared first and set last, as single writes would do."""
        found = self._whole(index, subindex)
        resizable = found.entries[0].access != "ro"
        count = data[0] if subindex == 0 and data else self.integer(index, 0)
        position = 2 if subindex == 0 else 0
        if resizable:
            self.write(index, 0, b"\0", state)
        for sub in (s for s in sorted(found.entries) if 1 <= s <= count):
            size = found.entries[sub].bits // 8
            if position + size > len(data):
                raise SdoAbort(aborts.TOO_SHORT)
            self.write(index, sub, data[position : position + size], state)
            position += size
        if position < len(data):
            raise SdoAbort(aborts.TOO_LONG)
        if resizable:
            self.write(index, 0, bytes([count]), state)

    def _whole(self, index: int, subindex: int) -> Object:
        found = self.objects.get(index)
        if found is None:
            raise SdoAbort(aborts.NO_OBJECT)
        if found.code == VARIABLE or subindex > 1:
            raise SdoAbort(aborts.NO_COMPLETE_ACCESS)
        return found
