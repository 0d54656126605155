"""A slave controller: register file and process memory of one slave, with what writing and reading them does.

Plain bytes stay bytes in ``memory``; the few registers that act are in the table of triggers. The slave object behind
is the very one that the in-process master serves.
"""

from __future__ import annotations

from collections.abc import Callable

from fakes.ethercat.slaves.al import AlState
from fakes.ethercat.slaves.slave import Slave
from fakes.ethercat.wire import clock, sii
from fakes.ethercat.wire import registers as reg
from fakes.ethercat.wire.mailbox import Mailbox

_PORT_OPEN, _PORT_CLOSED = 0b10, 0b01
"""DL status of a port: signal and loop open, or loop closed without signal."""


def _nothing() -> None:
    """Stand for a segment as long as there is none."""


class SlaveController:
    """Registers 0x0000-0x0FFF and memory 0x1000-0x2FFF in front of a slave.

    ``on_change`` is called when a setting changes that logical addressing depends on; the segment sets it.
    """

    def __init__(self, slave: Slave) -> None:
        self.slave = slave
        self.memory = bytearray(reg.MEMORY_SIZE)
        self.eeprom = bytearray(sii.build(slave))
        self.mailbox = Mailbox(self.memory, slave)
        self.position = 0
        self.last_position = 0
        self.on_change: Callable[[], None] = _nothing
        self.power_on()

    def power_on(self) -> None:
        """Bring every register to its content after power-on."""
        self.memory[:] = bytes(reg.MEMORY_SIZE)
        for address, content in reg.INITIAL:
            self.memory[address : address + len(content)] = content
        self.memory[reg.STATION_ALIAS : reg.STATION_ALIAS + 2] = self.eeprom[8:10]
        self.mailbox.reset()
        self.show_ports()
        self.on_change()

    @property
    def station(self) -> int:
        """Configured station address."""
        return self.memory[0x10] | self.memory[0x11] << 8

    @property
    def alias(self) -> int:
        """Station alias, or -1 while the master has not enabled it (DL control bit 24)."""
        return self.memory[0x12] | self.memory[0x13] << 8 if self.memory[reg.DL_CONTROL + 3] & 1 else -1

    def show_ports(self) -> None:
        """Set DL status for the place in the line: port 0 towards the master, port 1 onwards, 2 and 3 absent."""
        onwards = _PORT_OPEN if self.position < self.last_position else _PORT_CLOSED
        ports = _PORT_OPEN | onwards << 2 | _PORT_CLOSED << 4 | _PORT_CLOSED << 6
        links = 0x10 | (0x20 if onwards == _PORT_OPEN else 0)
        self.memory[reg.DL_STATUS : reg.DL_STATUS + 2] = bytes([0x03 | links, ports])

    # -- access by datagrams ------------------------------------------------------------------------------------

    def read(self, address: int, length: int) -> bytes | None:
        """Return memory as a datagram reads it, or None where the controller does not answer (an empty mailbox)."""
        if address >= reg.RAM:
            if self.mailbox.blocks_read(address, length):
                return None
            data = bytes(self.memory[address : address + length])
            self.mailbox.after_read(address, length)
            return data if len(data) == length else None
        stop = address + length
        if address < reg.DC_SYSTEM_TIME + 8 and stop > reg.DC_SYSTEM_TIME:
            self.memory[reg.DC_SYSTEM_TIME : reg.DC_SYSTEM_TIME + 8] = clock.system_time(self.memory)
        return bytes(self.memory[address:stop])

    def write(self, address: int, data: bytes) -> bool:
        """Write as a datagram does; return whether the controller took it."""
        stop = address + len(data)
        if address >= reg.RAM:
            if stop > reg.MEMORY_SIZE or self.mailbox.blocks_write(address):
                return False
            self.memory[address:stop] = data
            self.mailbox.after_write(stop)
            return True
        mask = int.from_bytes(reg.WRITABLE[address:stop], "little")
        old = int.from_bytes(self.memory[address:stop], "little")
        new = int.from_bytes(data[: reg.RAM - address], "little")
        merged = old & ~mask | new & mask
        self.memory[address : min(stop, reg.RAM)] = merged.to_bytes(min(stop, reg.RAM) - address, "little")
        for first, last, act in self._TRIGGERS:
            if address < last and stop > first:
                act(self)
        return True

    # -- what writing does --------------------------------------------------------------------------------------

    def _addressing(self) -> None:
        self.on_change()

    def _al_control(self) -> None:
        """Hand settings and request to the slave, show its answer."""
        for i, manager in enumerate(self.slave.sync_managers):
            at = reg.SYNC_MANAGER + reg.SYNC_MANAGER_SIZE * i
            manager.start = int.from_bytes(self.memory[at : at + 2], "little")
            manager.length = int.from_bytes(self.memory[at + 2 : at + 4], "little")
            manager.enabled = bool(self.memory[at + 6] & 0x01)
        self.slave.al.request(self.memory[reg.AL_CONTROL])
        if self.slave.al.state is AlState.INIT:
            self.mailbox.empty()
        self.show_state()

    def show_state(self) -> None:
        """Show the slave's AL state and code in the registers."""
        self.memory[reg.AL_STATUS] = self.slave.al.status
        self.memory[reg.AL_CODE : reg.AL_CODE + 2] = int(self.slave.al.code).to_bytes(2, "little")
        self.on_change()

    def show_watchdog(self, running: bool) -> None:
        """Show whether the process data watchdog runs (0x0440) and count its expiries (0x0442)."""
        self.memory[reg.WATCHDOG_STATUS] = int(running)
        if not running:
            self.memory[reg.WATCHDOG_COUNTER] = min(0xFF, self.memory[reg.WATCHDOG_COUNTER] + 1)

    def _error_counters(self) -> None:
        self.memory[reg.ERROR_COUNTERS : reg.ERROR_COUNTERS + 0x14] = bytes(0x14)

    def _watchdog(self) -> None:
        divider = int.from_bytes(self.memory[reg.WATCHDOG_DIVIDER : reg.WATCHDOG_DIVIDER + 2], "little")
        ticks = int.from_bytes(self.memory[reg.WATCHDOG_DATA : reg.WATCHDOG_DATA + 2], "little")
        self.slave.watchdog_s = 40e-9 * (divider + 2) * ticks

    def _watchdog_counters(self) -> None:
        self.memory[reg.WATCHDOG_COUNTER : reg.WATCHDOG_COUNTER + 2] = bytes(2)

    def _eeprom(self) -> None:
        """Serve an EEPROM command at once; the busy flag is never seen."""
        command = self.memory[reg.EEPROM_CONTROL + 1] & 0x07
        word = int.from_bytes(self.memory[reg.EEPROM_ADDRESS : reg.EEPROM_ADDRESS + 4], "little")
        at = 2 * word
        if command == 1:
            self.memory[reg.EEPROM_DATA : reg.EEPROM_DATA + 8] = bytes(self.eeprom[at : at + 8]).ljust(8, b"\xff")
        elif command == 2 and at + 2 <= len(self.eeprom):
            self.eeprom[at : at + 2] = self.memory[reg.EEPROM_DATA : reg.EEPROM_DATA + 2]
        self.memory[reg.EEPROM_CONTROL : reg.EEPROM_CONTROL + 2] = b"\x40\x00"

    def _sync_managers(self) -> None:
        self.mailbox.configure()
        self.on_change()

    def _latch(self) -> None:
        clock.latch(self.memory, self.position, self.last_position)

    _TRIGGERS: tuple[tuple[int, int, Callable[[SlaveController], None]], ...] = (
        (reg.STATION_ADDRESS, reg.STATION_ADDRESS + 2, _addressing),
        (reg.DL_CONTROL, reg.DL_CONTROL + 4, _addressing),
        (reg.AL_CONTROL, reg.AL_CONTROL + 1, _al_control),
        (reg.ERROR_COUNTERS, reg.ERROR_COUNTERS + 0x14, _error_counters),
        (reg.WATCHDOG_DIVIDER, reg.WATCHDOG_DATA + 2, _watchdog),
        (reg.WATCHDOG_COUNTER, reg.WATCHDOG_COUNTER + 2, _watchdog_counters),
        (reg.EEPROM_CONTROL, reg.EEPROM_CONTROL + 2, _eeprom),
        (reg.FMMU, reg.FMMU + reg.FMMU_SIZE * reg.FMMU_COUNT, _addressing),
        (
            reg.SYNC_MANAGER,
            reg.SYNC_MANAGER + reg.SYNC_MANAGER_SIZE * reg.SYNC_MANAGER_COUNT,
            _sync_managers,
        ),
        (reg.DC_RECEIVE, reg.DC_RECEIVE + 4, _latch),
    )
