"""SDO information: lists of objects, descriptions of objects and entries (ETG.1000.6 §5.6.3)."""

from __future__ import annotations

import struct

from fakes.ethercat.objects import aborts
from fakes.ethercat.objects.aborts import SdoAbort
from fakes.ethercat.objects.dictionary import VARIABLE, Object, ObjectDictionary

LIST_REQUEST, LIST, OBJECT_REQUEST, OBJECT, ENTRY_REQUEST, ENTRY, ERROR = range(1, 8)
_INCOMPLETE = 0x80
_IDENTITY_TYPE, _PDO_MAPPING_TYPE = 0x0023, 0x0021


def answer(dictionary: ObjectDictionary, request: bytes, room: int) -> list[bytes]:
    """Return the parts of the answer to an SDO information request, each at most ``room`` bytes."""
    opcode = request[0] & 0x7F if request else 0
    try:
        if opcode == LIST_REQUEST:
            return _fragments(LIST, _list(dictionary, *struct.unpack_from("<H", request, 4)), room)
        if opcode == OBJECT_REQUEST:
            return _fragments(OBJECT, _object(dictionary, *struct.unpack_from("<H", request, 4)), room)
        if opcode == ENTRY_REQUEST:
            return _fragments(ENTRY, _entry(dictionary, *struct.unpack_from("<HBB", request, 4)), room)
        raise SdoAbort(aborts.COMMAND)
    except SdoAbort as abort:
        return _fragments(ERROR, struct.pack("<I", abort.code), room)
    except struct.error:
        return _fragments(ERROR, struct.pack("<I", aborts.TOO_SHORT), room)


def _fragments(opcode: int, data: bytes, room: int) -> list[bytes]:
    size = room - 4
    parts = [data[i : i + size] for i in range(0, len(data), size)] or [b""]
    return [
        struct.pack("<BBH", opcode | (_INCOMPLETE if left else 0), 0, left) + part
        for part, left in zip(parts, range(len(parts) - 1, -1, -1), strict=True)
    ]


def _list(dictionary: ObjectDictionary, kind: int) -> bytes:
    lists = {n: _listed(dictionary, n) for n in range(1, 6)}
    if kind == 0:
        return struct.pack("<H5H", 0, *(len(lists[n]) for n in range(1, 6)))
    if kind not in lists:
        raise SdoAbort(aborts.RANGE)
    return struct.pack(f"<H{len(lists[kind])}H", kind, *lists[kind])


def _listed(dictionary: ObjectDictionary, kind: int) -> list[int]:
    """Return the indices of a list: 1 all, 2 RxPDO-mappable, 3 TxPDO-mappable, 4 stored, 5 start-up parameters."""

    def belongs(o: Object) -> bool:
        entries = o.entries.values()
        if kind in (2, 3):
            return any("rt"[kind - 2] in e.pdo for e in entries)
        return kind == 1 or (kind == 5 and any(e.access in ("rw", "rwpre") and not e.pdo for e in entries))

    return [index for index, o in dictionary.objects.items() if belongs(o)]


def _object(dictionary: ObjectDictionary, index: int) -> bytes:
    found = dictionary.objects.get(index)
    if found is None:
        raise SdoAbort(aborts.NO_OBJECT)
    return struct.pack("<HHBB", index, _type_of(found), max(found.entries), found.code) + found.name.encode()


def _type_of(found: Object) -> int:
    if found.index == 0x1018:
        return _IDENTITY_TYPE
    if 0x1600 <= found.index < 0x1800 or 0x1A00 <= found.index < 0x1C00:
        return _PDO_MAPPING_TYPE
    entry = found.entries[0 if found.code == VARIABLE else max(found.entries)]
    return entry.type.code


def _entry(dictionary: ObjectDictionary, index: int, subindex: int, info: int) -> bytes:
    entry = dictionary.entry(index, subindex)
    head = struct.pack("<HBBHHH", index, subindex, info, entry.type.code, entry.bits, entry.access_flags)
    return head + entry.name.encode()
