"""A slave as pysoem's master shows it, over an emulated slave object in the same process.

Names, units, return values and exceptions are those of ``pysoem.CdefSlave``, so that no driver notices. Positions in
exceptions count from 1, as pysoem's do.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Protocol

import pysoem

from fakes.ethercat.objects.aborts import TEXT, SdoAbort
from fakes.ethercat.objects.pdo import RX_ASSIGN, TX_ASSIGN
from fakes.ethercat.slaves.al import ERROR
from fakes.ethercat.slaves.slave import Slave

_SDO_BUFFER = 256
_WATCHDOG_UNIT_MS = 0.1
_WATCHDOG_LIMIT_MS = 6553.5
_MAILBOX_STATES = (pysoem.PREOP_STATE, pysoem.SAFEOP_STATE, pysoem.OP_STATE)


class Master(Protocol):
    """What a slave asks of the master it belongs to."""

    def check_open(self) -> None:
        """Raise pysoem's error where the master is not open."""

    def reaches(self, position: int) -> bool:
        """Whether the slave at a position (from 0) answers."""
        ...


class StandInSlave:
    """One slave of the emulated master."""

    def __init__(self, master: Master, position: int, slave: Slave) -> None:
        self._master = master
        self._position = position
        self._slave = slave
        self.state: int = pysoem.INIT_STATE
        self.al_status = 0
        self.is_lost = False
        self.config_func: Callable[[int], None] | None = None
        self.setup_func: Callable[[StandInSlave], None] | None = None
        self._callbacks: list[Callable[[pysoem.Emergency], None]] = []
        self.output_bytes = bytearray()
        self.input_bytes = bytearray()

    # -- identity -----------------------------------------------------------------------------------------------

    @property
    def man(self) -> int:
        """Vendor number."""
        return self._slave.identity.vendor

    @property
    def id(self) -> int:
        """Product code."""
        return self._slave.identity.product

    @property
    def rev(self) -> int:
        """Revision number."""
        return self._slave.identity.revision

    @property
    def name(self) -> str:
        """Name from the SII."""
        return self._slave.identity.order

    # -- process data -------------------------------------------------------------------------------------------

    @property
    def input(self) -> bytes:
        """Inputs received last."""
        return bytes(self.input_bytes)

    @property
    def output(self) -> bytes:
        """Outputs that will be sent next; only bytes can be assigned."""
        return bytes(self.output_bytes)

    @output.setter
    def output(self, value: bytes) -> None:
        if not isinstance(value, bytes):
            raise TypeError(f"expected bytes, {type(value).__name__} found")
        self.output_bytes[: len(value)] = value[: len(self.output_bytes)]

    # -- states -------------------------------------------------------------------------------------------------

    def reached(self) -> bool:
        """Whether frames reach the slave (a fault may keep them away)."""
        return self._master.reaches(self._position)

    def refresh(self) -> None:
        """Take over AL status and code, as reading its registers does; a slave out of reach gives 0."""
        self.state = self._slave.al.status if self.reached() else pysoem.NONE_STATE
        self.al_status = int(self._slave.al.code) if self.reached() else 0

    def request(self, control: int) -> None:
        """Write AL control."""
        if self.reached():
            self._slave.al.request(control)

    def write_state(self) -> int:
        """Request the state set in ``state``; the working counter comes back."""
        self._master.check_open()
        self.request(self.state)
        return 1 if self.reached() else 0

    def state_check(self, expected_state: int, timeout: int = 2000) -> int:
        """Return the state found; ``state`` is refreshed."""
        self._master.check_open()
        self.refresh()
        return self.state

    def configure_mailbox(self) -> None:
        """Set the mailbox sync managers, as the scan does."""
        for manager, start in zip(self._slave.sync_managers[:2], (0x1000, 0x1200), strict=True):
            manager.start, manager.length, manager.enabled = start, 256, True

    def map(self) -> tuple[int, int]:
        """Run the configuration hook and set the process data sync managers; return their sizes in bytes."""
        if self.config_func is not None:
            self.config_func(self._position)
        elif self.setup_func is not None:
            self.setup_func(self)
        sizes = (self._slave.layout(RX_ASSIGN).size, self._slave.layout(TX_ASSIGN).size)
        for manager, start, size in zip(self._slave.sync_managers[2:], (0x1400, 0x1A00), sizes, strict=True):
            manager.start, manager.length, manager.enabled = start, size, size > 0
        return sizes

    def reconfig(self, timeout: int = 500) -> int:
        """Bring a slave that came back from INIT to SAFE-OPERATIONAL with its hook; return the state, 0 while lost."""
        self._master.check_open()
        if not self.reached():
            return 0
        self._slave.al.request(pysoem.INIT_STATE | ERROR)
        self.configure_mailbox()
        self._slave.al.request(pysoem.PREOP_STATE)
        self.map()
        self._slave.al.request(pysoem.SAFEOP_STATE)
        self.refresh()
        return self.state

    def recover(self, timeout: int = 500) -> int:
        """Find a slave again that had been lost; 1 if it answers, else 0."""
        self._master.check_open()
        return 1 if self.reached() else 0

    # -- SDO ----------------------------------------------------------------------------------------------------

    def sdo_read(
        self, index: int, subindex: int, size: int = 0, ca: bool = False, *, release_gil: bool | None = None
    ) -> bytes:
        """Read an object; 256 bytes at most unless ``size`` says more."""
        dictionary = self._slave.dictionary
        data = self._sdo(
            index, subindex, lambda: (dictionary.read_complete if ca else dictionary.read)(index, subindex)
        )
        if len(data) > (size or _SDO_BUFFER):
            raise pysoem.PacketError(self._position + 1, 3)
        return data

    def sdo_write(
        self, index: int, subindex: int, data: bytes, ca: bool = False, *, release_gil: bool | None = None
    ) -> None:
        """Write an object."""
        if not isinstance(data, bytes):
            raise TypeError(f"expected bytes, {type(data).__name__} found")
        dictionary = self._slave.dictionary
        write = dictionary.write_complete if ca else dictionary.write

        def do() -> bytes:
            write(index, subindex, data, int(self._slave.al.state))
            return b""

        self._sdo(index, subindex, do)

    def _sdo(self, index: int, subindex: int, do: Callable[[], bytes]) -> bytes:
        self._master.check_open()
        if not self.reached() or self._slave.al.state not in _MAILBOX_STATES:
            raise pysoem.WkcError(wkc=0)
        self._deliver_emergencies()
        try:
            return do()
        except SdoAbort as abort:
            text = TEXT.get(abort.code, "unknown")
            raise pysoem.SdoError(self._position + 1, index, subindex, abort.code, text) from None

    def mbx_receive(self) -> int:
        """Fetch what waits in the mailbox: emergencies go to the callbacks, and as with SOEM the counter is 0 then."""
        self._master.check_open()
        self._deliver_emergencies()
        return 0

    def add_emergency_callback(self, callback: Callable[[pysoem.Emergency], None]) -> None:
        """Have a function called for each emergency message that comes."""
        self._callbacks.append(callback)

    def _deliver_emergencies(self) -> None:
        if not self.reached():
            return
        waiting, self._slave.emergencies[:] = list(self._slave.emergencies), []
        for found in waiting:
            words = int.from_bytes(found.data[1:3], "little"), int.from_bytes(found.data[3:5], "little")
            message = pysoem.Emergency(self._position + 1, found.code, found.register, found.data[0], *words)
            if not self._callbacks:
                raise message
            for callback in self._callbacks:
                callback(message)

    # -- settings -----------------------------------------------------------------------------------------------

    def set_watchdog(self, wd_type: str, wd_time_ms: float) -> None:
        """Set the process data watchdog in ms (the PDI watchdog is accepted and has no effect)."""
        self._check_watchdog(wd_type)
        if wd_time_ms > _WATCHDOG_LIMIT_MS:
            raise AttributeError(f"wd_time_ms is limited to {_WATCHDOG_LIMIT_MS} ms")
        actual = int(wd_time_ms / _WATCHDOG_UNIT_MS + 1e-9) * _WATCHDOG_UNIT_MS
        if wd_type == "processdata":
            self._slave.watchdog_s = actual / 1000.0
        if abs(actual - wd_time_ms) > 1e-9:
            warnings.warn(
                f"The watchdog time is {actual} ms, not {wd_time_ms} ms: resolution", UserWarning, stacklevel=2
            )

    def get_watchdog(self, wd_type: str) -> float:
        """Return a watchdog time in ms."""
        self._check_watchdog(wd_type)
        return self._slave.watchdog_s * 1000.0 if wd_type == "processdata" else 100.0

    def _check_watchdog(self, wd_type: str) -> None:
        self._master.check_open()
        if wd_type not in ("pdi", "processdata"):
            raise AttributeError
        if not self.reached():
            raise pysoem.WkcError

    def dc_sync(
        self, act: bool, sync0_cycle_time: int, sync0_shift_time: int = 0, sync1_cycle_time: int | None = None
    ) -> None:
        """Set the SYNC pulses; in emulated time every slave is in step anyway."""
        self._master.check_open()
