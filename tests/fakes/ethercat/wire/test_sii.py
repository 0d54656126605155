"""EEPROM content against the layout of ETG.2010."""

from __future__ import annotations

import struct

import pytest

from fakes.ethercat.wire import sii
from tests.fakes.ethercat.simple_plant import simple_bench


def categories(content):
    found, at = {}, 0x80
    while True:
        kind, words = struct.unpack_from("<HH", content, at)
        if kind == sii.END:
            return found
        found.setdefault(kind, []).append(content[at + 4 : at + 4 + 2 * words])
        at += 4 + 2 * words


@pytest.mark.parametrize("position", range(4))
def test_identity_mailbox_and_categories(position):
    slave = simple_bench().slaves[position]
    content = sii.build(slave)
    assert len(content) == 2048
    identity = slave.identity
    assert struct.unpack_from("<4I", content, 0x10) == (identity.vendor, identity.product, 0x10000, identity.serial)
    assert struct.unpack_from("<5H", content, 0x30) == (0x1000, 256, 0x1200, 256, 4)
    found = categories(content)
    assert set(found) >= {sii.STRINGS, sii.GENERAL, sii.FMMU, sii.SYNC_MANAGERS, sii.TX_PDO}
    strings = found[sii.STRINGS][0]
    general = found[sii.GENERAL][0]
    assert len(general) == 32
    assert general[5] == sii.COE_DETAILS
    assert string(strings, general[2]) == identity.order
    assert string(strings, general[3]) == identity.name
    sizes = [struct.unpack_from("<HHBBBB", found[sii.SYNC_MANAGERS][0], 8 * i)[1] for i in range(4)]
    assert sizes[2:] == [slave.outputs.size, slave.inputs.size]
    bits = {
        kind: sum(sum(pdo[8 + 8 * i + 5] for i in range(pdo[2])) for pdo in found.get(kind, [])) for kind in (50, 51)
    }
    assert (bits[51], bits[50]) == (8 * slave.outputs.size, 8 * slave.inputs.size)


def string(category, index):
    at = 1
    for _ in range(index - 1):
        at += 1 + category[at]
    return category[at + 1 : at + 1 + category[at]].decode()


def test_checksum_of_a_known_configuration():
    """CRC-8, polynomial 0x07 from 0xFF: the check value of "123456789" is 0xFB."""
    assert sii.checksum(b"123456789") == 0xFB
    content = sii.build(simple_bench().slaves[0])
    assert content[14] == sii.checksum(content[:14])
