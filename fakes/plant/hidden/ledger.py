"""File with the part of each channel that each hidden effect adds, every few cycles; a sealed truth is made from it.

Rows stand at their cycle's place, so that cycles which a master takes back and runs again simply overwrite theirs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fakes.plant.hidden.kinds import SHOWN

EVERY = 20
"""bus cycles between two rows: 100 Hz on the bench"""


def row_dtype(count: int) -> np.dtype[Any]:
    """Return the layout of a row for ``count`` kinds: counts of both encoders, then what is shown (count, 4)."""
    return np.dtype([("input_position", "i8"), ("load_position", "i8"), ("shown", "f4", (count, len(SHOWN)))])


class Ledger:
    """The file at ``path``, begun anew, for ``count`` kinds."""

    def __init__(self, path: str | Path, count: int) -> None:
        self._path, self._dtype = Path(path), row_dtype(count)
        self._path.write_bytes(b"")

    def add(self, cycle: int, effects: NDArray[np.float32], measurements: NDArray[Any]) -> None:
        """Write the rows of a block (n, count, 4) that began at ``cycle``."""
        first = -cycle % EVERY
        picked = slice(first, None, EVERY)
        rows = np.zeros(len(range(first, len(effects), EVERY)), self._dtype)
        if not rows.size:
            return
        rows["shown"] = effects[picked]
        for name in ("input_position", "load_position"):
            rows[name] = measurements[name][picked]
        with self._path.open("r+b") as file:
            file.seek((cycle + first) // EVERY * self._dtype.itemsize)
            file.write(rows.tobytes())


def read_ledger(path: str | Path, count: int) -> NDArray[Any]:
    """Return the rows of a ledger; row k is that of the plant's cycle k·EVERY."""
    return np.fromfile(Path(path), row_dtype(count))
