"""Runs of a condition over blocks of samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def run_lengths(condition: NDArray[np.bool_], carry: int = 0) -> NDArray[np.int64]:
    """Return (n,) how many samples in a row, up to and with each, a condition has held.

    Parameters
    ----------
    condition : mask (n,).
    carry : length of the run at the end of the block before.
    """
    rows = np.arange(len(condition), dtype=np.int64)
    last_false = np.maximum.accumulate(np.where(condition, -1 - carry, rows))
    return rows - last_false
