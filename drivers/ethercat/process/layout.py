"""The memory the rig and the bus process share: a header of words, a ring of set values, a ring of process images.

Each word has one writer. A ring's head is written after its rows, and read before them; rows are counted from the start
and never wrap, places in the ring are the count modulo its length.
"""

from __future__ import annotations

import mmap
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

HEADER_WORDS = 64

# words the bus process writes
STATE, IMAGE_HEAD, SET_USED, SET_NEXT, STOP_REASON, STOP_IMAGE, EXPECTED_WKC, PID, RESUMED, DETAIL = range(10)
# words the rig writes
SET_HEAD, SKIP_TO, HOLD_LIMIT, STOP_ORDER, RESUME, SILENCE = range(32, 38)

STARTING, CYCLING, STOPPING, STOPPED, CLOSED = range(5)
"""Values of STATE."""

META = struct.Struct("<8q")
META_WORDS = 8
CYCLE, DUE, WOKE, BACK, DONE, SET_INDEX, WKC, MODE = range(META_WORDS)
"""Words beside each image: number of the cycle's slot; monotonic times in ns at which it was due, began, had its frame
back and was done (images handed over); which set values were sent (−1: those of a stop); working counter; STATE."""


@dataclass(frozen=True, slots=True)
class Layout:
    """Where everything is, in bytes.

    Attributes
    ----------
    out_width, in_width : bytes of the process images.
    set_rows, image_rows : length of the rings.
    """

    out_width: int
    in_width: int
    set_rows: int
    image_rows: int

    @property
    def set_values(self) -> int:
        """Start of the ring of set values."""
        return 8 * HEADER_WORDS

    @property
    def meta(self) -> int:
        """Start of the words beside the images."""
        return _aligned(self.set_values + self.set_rows * self.out_width)

    @property
    def sent(self) -> int:
        """Start of the outputs as sent."""
        return self.meta + self.image_rows * META.size

    @property
    def inputs(self) -> int:
        """Start of the inputs."""
        return _aligned(self.sent + self.image_rows * self.out_width)

    @property
    def size(self) -> int:
        """Bytes altogether."""
        return _aligned(self.inputs + self.image_rows * self.in_width)


def _aligned(offset: int) -> int:
    return (offset + 63) // 64 * 64


class Shared:
    """The mapped memory, as both sides use it.

    Attributes
    ----------
    words : int64 (HEADER_WORDS,); one word is read and written at once.
    set_values, sent, inputs : uint8 (rows, width).
    meta : int64 (image_rows, META_WORDS).
    """

    def __init__(self, descriptor: int, layout: Layout, *, read_only: bool = False) -> None:
        protection = mmap.PROT_READ if read_only else mmap.PROT_READ | mmap.PROT_WRITE
        self.layout = layout
        self.map = mmap.mmap(descriptor, layout.size, mmap.MAP_SHARED, protection)
        self.words = memoryview(self.map)[: 8 * HEADER_WORDS].cast("q")
        self.set_values = self._array(layout.set_values, np.uint8, (layout.set_rows, layout.out_width))
        self.meta = self._array(layout.meta, np.int64, (layout.image_rows, META_WORDS))
        self.sent = self._array(layout.sent, np.uint8, (layout.image_rows, layout.out_width))
        self.inputs = self._array(layout.inputs, np.uint8, (layout.image_rows, layout.in_width))

    def _array(self, offset: int, dtype: Any, shape: tuple[int, int]) -> NDArray[Any]:
        return np.ndarray(shape, dtype, self.map, offset)
