"""Register map of an EtherCAT slave controller as the emulated ones have it (ETG.1000.4 §6, ESC data sheet section II).

Only what a master may look at; the rest of the register space reads as zero.
"""

from __future__ import annotations

MEMORY_SIZE = 0x3000
RAM = 0x1000

STATION_ADDRESS, STATION_ALIAS = 0x0010, 0x0012
DL_CONTROL, DL_STATUS = 0x0100, 0x0110
AL_CONTROL, AL_STATUS, AL_CODE = 0x0120, 0x0130, 0x0134
EVENT_MASK, EVENT_REQUEST = 0x0200, 0x0210
ERROR_COUNTERS = 0x0300
WATCHDOG_DIVIDER, WATCHDOG_PDI, WATCHDOG_DATA = 0x0400, 0x0410, 0x0420
WATCHDOG_STATUS, WATCHDOG_COUNTER = 0x0440, 0x0442
EEPROM_CONFIG, EEPROM_CONTROL, EEPROM_ADDRESS, EEPROM_DATA = 0x0500, 0x0502, 0x0504, 0x0508
FMMU, FMMU_SIZE, FMMU_COUNT = 0x0600, 16, 8
SYNC_MANAGER, SYNC_MANAGER_SIZE, SYNC_MANAGER_COUNT = 0x0800, 8, 4
DC_RECEIVE, DC_SYSTEM_TIME, DC_RECEIVE_UNIT, DC_OFFSET, DC_DELAY = 0x0900, 0x0910, 0x0918, 0x0920, 0x0928
DC_SPEED, DC_SYNC = 0x0930, 0x0980

MAILBOX_FULL = 0x08
"""Sync manager status bit 3."""

INITIAL: tuple[tuple[int, bytes], ...] = (
    (0x0000, bytes([0x11, 0x00, 0x02, 0x00])),  # type, revision, build
    (0x0004, bytes([FMMU_COUNT, SYNC_MANAGER_COUNT, (MEMORY_SIZE - RAM) // 1024, 0x0F])),  # RAM in KiB, ports
    (0x0008, bytes([0x0C, 0x00])),  # distributed clocks, 64 bit
    (DL_CONTROL, bytes([0x01, 0x00, 0x07, 0x00])),
    (AL_CONTROL, bytes([0x01, 0x00])),
    (AL_STATUS, bytes([0x01, 0x00])),
    (0x0140, bytes([0x80, 0x0C])),  # on-chip bus
    (WATCHDOG_DIVIDER, (2498).to_bytes(2, "little")),
    (WATCHDOG_PDI, (1000).to_bytes(2, "little")),
    (WATCHDOG_DATA, (1000).to_bytes(2, "little")),
    (WATCHDOG_STATUS, bytes([0x01, 0x00])),
    (EEPROM_CONTROL, bytes([0x40, 0x00])),  # reads 8 bytes
    (DC_SPEED, (0x1000).to_bytes(2, "little")),
    (0x0934, bytes([0x00, 0x0C])),
)
"""Content after power-on: (address, bytes)."""

_WRITABLE: tuple[tuple[int, int], ...] = (
    (STATION_ADDRESS, 2),
    (DL_CONTROL, 4),
    (AL_CONTROL, 2),
    (EVENT_MASK, 2),
    (0x0204, 4),
    (ERROR_COUNTERS, 0x14),
    (WATCHDOG_DIVIDER, 2),
    (WATCHDOG_PDI, 2),
    (WATCHDOG_DATA, 2),
    (WATCHDOG_COUNTER, 2),
    (EEPROM_CONFIG, 16),
    (FMMU, FMMU_SIZE * FMMU_COUNT),
    (DC_OFFSET, 8),
    (DC_DELAY, 4),
    (DC_SPEED, 2),
    (0x0934, 2),
    (DC_SYNC, 0x30),
    *((SYNC_MANAGER + SYNC_MANAGER_SIZE * i, 5) for i in range(SYNC_MANAGER_COUNT)),
    *((SYNC_MANAGER + SYNC_MANAGER_SIZE * i + 6, 1) for i in range(SYNC_MANAGER_COUNT)),
)


def _mask() -> bytes:
    mask = bytearray(RAM)
    for start, length in _WRITABLE:
        mask[start : start + length] = b"\xff" * length
    return bytes(mask)


WRITABLE = _mask()
"""0xFF for each register byte a master may write."""
