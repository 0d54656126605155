"""Write the process data a slave should have: content of its PDOs, then their assignment to the sync managers."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.ethercat.sdo import SdoClient
from drivers.ethercat.slave import Pdo, SlaveSpec

RX_ASSIGN, TX_ASSIGN = 0x1C12, 0x1C13
"""Assignment of RxPDOs to sync manager 2 and of TxPDOs to sync manager 3 (ETG.1000.6)."""


def assign_pdos(sdo: SdoClient, spec: SlaveSpec) -> None:
    """Write mapping and assignment in PREOP.

    The order is that of CiA 301, 7.5.2.36: the assignment is emptied, each PDO switched off (subindex 0 = 0), filled
    and switched on with its number of entries, then assigned. A slave whose PDOs are all fixed and already assigned
    is left as it is.

    Raises
    ------
    SdoAccessError
        With the object the slave refused.
    """
    for assignment, pdos in ((RX_ASSIGN, spec.rx_pdos), (TX_ASSIGN, spec.tx_pdos)):
        if pdos and not _is_assigned(sdo, assignment, pdos):
            _assign(sdo, assignment, pdos)


def _is_assigned(sdo: SdoClient, assignment: int, pdos: Sequence[Pdo]) -> bool:
    """Terminals with fixed content often have a fixed assignment as well: write only what differs."""
    if not all(pdo.fixed for pdo in pdos):
        return False
    count = sdo.read(assignment, 0, "u1")
    return [sdo.read(assignment, i + 1, "u2") for i in range(count)] == [pdo.index for pdo in pdos]


def _assign(sdo: SdoClient, assignment: int, pdos: Sequence[Pdo]) -> None:
    sdo.write(assignment, 0, "u1", 0)
    for pdo in pdos:
        if not pdo.fixed:
            sdo.write(pdo.index, 0, "u1", 0)
            for i, entry in enumerate(pdo.entries):
                sdo.write(pdo.index, i + 1, "u4", entry.mapping)
            sdo.write(pdo.index, 0, "u1", len(pdo.entries))
    for i, pdo in enumerate(pdos):
        sdo.write(assignment, i + 1, "u2", pdo.index)
    sdo.write_checked(assignment, 0, "u1", len(pdos))
