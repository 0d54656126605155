"""The process image of the whole bus as arrays: one row a cycle, one structured view a slave."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.entries import Entry, entries_dtype


@dataclass(frozen=True, slots=True)
class Image:
    """One direction of the process image.

    Attributes
    ----------
    bytes : uint8 array (capacity, width), the slaves' images side by side in the order of the bus.
    views : structured array (capacity,) a slave, in the same memory.
    spans : columns (start, stop) of each slave, by place on the bus.
    """

    bytes: NDArray[np.uint8]
    views: dict[str, NDArray[Any]]
    spans: tuple[tuple[int, int], ...]

    @classmethod
    def build(
        cls, slaves: Sequence[tuple[str, tuple[Entry, ...]]], capacity: int, data: NDArray[np.uint8] | None = None
    ) -> Image:
        """Lay out slaves (name, entries) in the order given, for blocks of up to ``capacity`` cycles.

        ``data`` is memory to use, uint8 (capacity, width), such as that shared with another process.
        """
        dtypes = [entries_dtype(entries) for _, entries in slaves]
        edges = list(itertools.accumulate((dtype.itemsize for dtype in dtypes), initial=0))
        if data is None:
            data = np.zeros((capacity, edges[-1]), np.uint8)
        views = {
            name: data[:, start:stop].view(dtype)[:, 0]
            for (name, _), dtype, start, stop in zip(slaves, dtypes, edges, edges[1:], strict=False)
            if stop > start
        }
        return cls(data, views, tuple(itertools.pairwise(edges)))
