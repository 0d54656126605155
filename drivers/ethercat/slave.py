"""What a slave on the bus should be: identity, place, process data, settings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from drivers.entries import Entry

if TYPE_CHECKING:
    from drivers.ethercat.sdo import SdoClient


@dataclass(frozen=True, slots=True)
class Pdo:
    """One process data object.

    Parameters
    ----------
    index : mapping object, 0x1600–0x17FF (outputs) or 0x1A00–0x1BFF (inputs).
    entries : what it carries, in order.
    fixed : the device does not let its content be changed (most terminals); it is then only assigned.
    """

    index: int
    entries: tuple[Entry, ...]
    fixed: bool = False


@dataclass(frozen=True, slots=True)
class SlaveSpec:
    """One slave as the configuration wants it.

    Parameters
    ----------
    name : what the configuration calls it; the key of process data.
    position : place on the bus, counted from 1 at the master.
    vendor, product : identity in the SII (0x1018:01, 0x1018:02).
    rx_pdos, tx_pdos : outputs (master to slave) and inputs, in order of assignment.
    revision : required revision (0x1018:03); None takes any.
    watchdog_s : process data watchdog of the slave (register 0x0420), s; None leaves the device's.
    sync0_shift_ns : SYNC0 shift where the slave runs on distributed clocks, ns; None leaves it without SYNC0.
    configure : called with SDO access between PREOP and SAFEOP, after the PDO assignment, at start and again whenever
        the slave comes back from a loss (it has then forgotten its settings).
    coe : the slave has a mailbox with an object dictionary; simple digital terminals have none, and nothing is written
        to them.
    """

    name: str
    position: int
    vendor: int
    product: int
    rx_pdos: tuple[Pdo, ...] = ()
    tx_pdos: tuple[Pdo, ...] = ()
    revision: int | None = None
    watchdog_s: float | None = None
    sync0_shift_ns: int | None = None
    configure: Callable[[SdoClient], None] | None = None
    coe: bool = True

    @property
    def outputs(self) -> tuple[Entry, ...]:
        """Entries of all RxPDOs in the order of the process image."""
        return tuple(entry for pdo in self.rx_pdos for entry in pdo.entries)

    @property
    def inputs(self) -> tuple[Entry, ...]:
        """Entries of all TxPDOs in the order of the process image."""
        return tuple(entry for pdo in self.tx_pdos for entry in pdo.entries)

    @property
    def identity(self) -> str:
        """Vendor, product and, where required, revision, for people."""
        text = f"vendor 0x{self.vendor:08X}, product 0x{self.product:08X}"
        return text if self.revision is None else f"{text}, revision 0x{self.revision:08X}"
