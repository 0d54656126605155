"""Status words of analogue EtherCAT terminals (profile 5001): which readings are valid, and when they were made."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

UNDERRANGE = 1 << 0
OVERRANGE = 1 << 1
ERROR = 1 << 6
INVALID = 1 << 14
TOGGLE = 1 << 15
"""Bits of the status word before a value: subindices 01, 02, 07, 0F (TxPDO state) and 10 (TxPDO toggle) of 0x6000."""


def usable(status: NDArray[np.uint16]) -> NDArray[np.bool_]:
    """Mask (n,) of readings that are neither out of range nor in error nor invalid."""
    mask: NDArray[np.bool_] = status & np.uint16(UNDERRANGE | OVERRANGE | ERROR | INVALID) == 0
    return mask


def ages(status: NDArray[np.uint16], previous_toggle: int, previous_age: int) -> NDArray[np.int64]:
    """Age (n,) of each reading, in cycles since the toggle bit last changed.

    Parameters
    ----------
    status : status words (n,) of a block.
    previous_toggle, previous_age : toggle bit (0 or :data:`TOGGLE`) and age at the end of the block before.
    """
    toggles = status & TOGGLE
    changed = np.diff(toggles, prepend=np.uint16(previous_toggle)) != 0
    rows = np.arange(len(status), dtype=np.int64)
    last_change = np.maximum.accumulate(np.where(changed, rows, -1 - previous_age))
    return rows - last_change
