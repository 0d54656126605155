"""Objects every slave has: identity, error handling, synchronisation (ETG.1000.6 §5.6.7.4, ETG.1020)."""

from __future__ import annotations

from fakes.ethercat.objects.dictionary import Entry, Object, array, record, variable
from fakes.ethercat.objects.identity import Identity
from fakes.ethercat.objects.pdo import RX_ASSIGN, TX_ASSIGN, mapping_word
from fakes.ethercat.objects.types import STRING, UDINT, UINT, USINT

MAILBOX_OUT, MAILBOX_IN, OUTPUTS, INPUTS = 1, 2, 3, 4
"""Sync manager communication types (0x1C00)."""

SYNC_TYPES = 0x0001 | 0x0002 | 0x0004
"""Free run, SM-synchronous and DC SYNC0 are supported (0x1C32:04)."""


def common(identity: Identity, cycle_time_ns: int, minimum_cycle_ns: int = 62_500) -> tuple[Object, ...]:
    """Return the objects whose content does not depend on the kind of slave."""
    return (
        variable(0x1000, "Device type", UDINT, "ro", identity.profile),
        variable(0x1001, "Error register", USINT, "ro", 0, "t"),
        variable(0x1008, "Device name", STRING, "ro", identity.name.encode()),
        variable(0x1009, "Hardware version", STRING, "ro", identity.hardware.encode()),
        variable(0x100A, "Software version", STRING, "ro", identity.software.encode()),
        record(
            0x1018,
            "Identity",
            Entry("Vendor ID", UDINT, "ro", identity.vendor),
            Entry("Product code", UDINT, "ro", identity.product),
            Entry("Revision", UDINT, "ro", identity.revision),
            Entry("Serial number", UDINT, "ro", identity.serial),
        ),
        record(
            0x10F1,
            "Error settings",
            Entry("Local error reaction", UDINT, "rw", 1),
            Entry("Sync error counter limit", UINT, "rw", 4),
        ),
        variable(0x2001, "User text", STRING, "rw", b""),
        array(0x1C00, "Sync manager type", USINT, (MAILBOX_OUT, MAILBOX_IN, OUTPUTS, INPUTS), "ro"),
        *(
            _synchronisation(0x1C32 + i, side, cycle_time_ns, minimum_cycle_ns)
            for i, side in enumerate(("output", "input"))
        ),
    )


def _synchronisation(index: int, side: str, cycle_time_ns: int, minimum_cycle_ns: int) -> Object:
    return record(
        index,
        f"SM {side} parameter",
        Entry("Synchronization type", UINT, "rw", 1, low=0, high=3),
        Entry("Cycle time", UDINT, "rw", cycle_time_ns),
        Entry("Shift time", UDINT, "rw", 0),
        Entry("Synchronization types supported", UINT, "ro", SYNC_TYPES),
        Entry("Minimum cycle time", UDINT, "ro", minimum_cycle_ns),
        Entry("Calc and copy time", UDINT, "ro", 0),
    )


def assignments(rx: tuple[int, ...], tx: tuple[int, ...], access: str) -> tuple[Object, ...]:
    """Return 0x1C12 and 0x1C13 with the PDOs assigned by default."""
    return (
        array(RX_ASSIGN, "RxPDO assign", UINT, rx, access, capacity=4 if access != "ro" else 0),
        array(TX_ASSIGN, "TxPDO assign", UINT, tx, access, capacity=4 if access != "ro" else 0),
    )


def mapping(index: int, name: str, entries: tuple[tuple[int, int, int], ...], access: str) -> Object:
    """Return a mapping object of (index, subindex, bits) entries; a writable one holds up to 16."""
    words = [mapping_word(*entry) for entry in entries]
    return array(index, name, UDINT, words, access, capacity=16 if access != "ro" else 0)
