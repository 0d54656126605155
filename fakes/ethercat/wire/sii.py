"""The slave information interface (EEPROM) of a slave, built from its identity and default mapping (ETG.2010)."""

from __future__ import annotations

import struct

from fakes.ethercat.objects.identity import VENDOR_NAME
from fakes.ethercat.objects.pdo import RX_ASSIGN, TX_ASSIGN
from fakes.ethercat.slaves.slave import (
    INPUT_ADDRESS,
    MAILBOX_IN_ADDRESS,
    MAILBOX_OUT_ADDRESS,
    MAILBOX_SIZE,
    OUTPUT_ADDRESS,
    Slave,
)

STRINGS, GENERAL, FMMU, SYNC_MANAGERS, TX_PDO, RX_PDO, CLOCK, END = 10, 30, 40, 41, 50, 51, 60, 0xFFFF
SIZE = 2048
COE_PROTOCOL = 0x0004
COE_DETAILS = 0x01 | 0x02 | 0x04 | 0x08 | 0x20
"""SDO, SDO information, PDO assignment, PDO configuration, complete access."""

SM_MAILBOX_OUT, SM_MAILBOX_IN, SM_OUTPUTS, SM_INPUTS = 0x26, 0x22, 0x64, 0x20
"""Control bytes: mailbox with interrupt; three buffers, outputs watched by the watchdog."""


class _Strings:
    """Category 10; indices count from 1."""

    def __init__(self) -> None:
        self._texts: list[bytes] = []

    def index(self, text: str) -> int:
        data = text.encode()[:255]
        if data not in self._texts:
            self._texts.append(data)
        return self._texts.index(data) + 1

    def category(self) -> bytes:
        return bytes([len(self._texts)]) + b"".join(bytes([len(t)]) + t for t in self._texts)


def checksum(words: bytes) -> int:
    """Return the CRC-8 (x⁸ + x² + x + 1, from 0xFF) over the configuration area."""
    crc = 0xFF
    for byte in words:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ (0x07 if crc & 0x80 else 0)) & 0xFF
    return crc


def build(slave: Slave) -> bytes:
    """Return the EEPROM content of a slave, 2 KiB."""
    identity = slave.identity
    configuration = struct.pack("<4HH4x", 0x0C80, 0, 0, 0, 0)
    head = bytearray(0x80)
    head[0:14] = configuration
    head[14] = checksum(configuration)
    struct.pack_into("<4I", head, 0x10, identity.vendor, identity.product, identity.revision, identity.serial)
    mailbox = (MAILBOX_OUT_ADDRESS, MAILBOX_SIZE, MAILBOX_IN_ADDRESS, MAILBOX_SIZE, COE_PROTOCOL)
    struct.pack_into("<5H", head, 0x30, *mailbox)
    struct.pack_into("<2H", head, 0x7C, SIZE * 8 // 1024 - 1, 1)
    strings = _Strings()
    order, group, name = strings.index(identity.order), strings.index(VENDOR_NAME), strings.index(identity.name)
    categories = [
        (GENERAL, struct.pack("<4Bx7Bh18x", group, 0, order, name, COE_DETAILS, *(0,) * 7)),
        (FMMU, bytes([1, 2, 3, 0])),
        (SYNC_MANAGERS, _sync_managers(slave)),
        *((TX_PDO, _pdo(slave, strings, pdo, 3)) for pdo in _assigned(slave, TX_ASSIGN)),
        *((RX_PDO, _pdo(slave, strings, pdo, 2)) for pdo in _assigned(slave, RX_ASSIGN)),
        (CLOCK, struct.pack("<3iH2hBB4x", 0, 0, 0, 0, 0x0300, 1, strings.index("DC"), 0)),
    ]
    content = bytes(head) + _category(STRINGS, strings.category())
    content += b"".join(_category(kind, data) for kind, data in categories)
    content += struct.pack("<H", END)
    return content.ljust(SIZE, b"\xff")


def _category(kind: int, data: bytes) -> bytes:
    padded = data + b"\0" * (len(data) % 2)
    return struct.pack("<HH", kind, len(padded) // 2) + padded


def _sync_managers(slave: Slave) -> bytes:
    outputs, inputs = slave.layout(RX_ASSIGN).size, slave.layout(TX_ASSIGN).size
    rows = (
        (MAILBOX_OUT_ADDRESS, MAILBOX_SIZE, SM_MAILBOX_OUT, 1, 1),
        (MAILBOX_IN_ADDRESS, MAILBOX_SIZE, SM_MAILBOX_IN, 1, 2),
        (OUTPUT_ADDRESS, outputs, SM_OUTPUTS, int(outputs > 0), 3),
        (INPUT_ADDRESS, inputs, SM_INPUTS, int(inputs > 0), 4),
    )
    return b"".join(struct.pack("<HHBxBB", *row) for row in rows)


def _assigned(slave: Slave, assignment: int) -> list[int]:
    d = slave.dictionary
    return [d.integer(assignment, sub) for sub in range(1, d.integer(assignment) + 1)]


def _pdo(slave: Slave, strings: _Strings, index: int, manager: int) -> bytes:
    d = slave.dictionary
    words = [d.integer(index, sub) for sub in range(1, d.integer(index) + 1)]
    name = strings.index(d.objects[index].name)
    data = struct.pack("<HBBBBH", index, len(words), manager, 0, name, 0)
    for word in words:
        entry = d.entry(word >> 16, word >> 8 & 0xFF)
        data += struct.pack(
            "<HBBBBH", word >> 16, word >> 8 & 0xFF, strings.index(entry.name), entry.type.code, word & 0xFF, 0
        )
    return data
