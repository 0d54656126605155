"""Angles of any length from encoder counts that overflow (0x6064 is a 32-bit integer)."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def _extend(raw: NDArray[np.int32], last_raw: int, last: int, out: NDArray[np.int64]) -> int:
    half, full = 1 << 31, 1 << 32
    for i in range(raw.size):
        step = int(raw[i]) - last_raw
        if step >= half:
            step -= full
        elif step < -half:
            step += full
        last_raw += step
        # back into the range of the device, so that the next difference is one of its integers
        if last_raw >= half:
            last_raw -= full
        elif last_raw < -half:
            last_raw += full
        last += step
        out[i] = last
    return last


class Unwrapper:
    """Extends 32-bit counts to 64 bits by counting overflows; remembers where it was between blocks.

    Valid as long as a shaft moves by less than 2³¹ counts from one sample to the next.
    """

    def __init__(self) -> None:
        self._raw: int | None = None
        self._value = 0

    def __call__(self, raw: NDArray[np.int32]) -> NDArray[np.int64]:
        """Return int64 counts (n,); the very first value keeps the device's own count."""
        out = np.empty(raw.size, np.int64)
        if raw.size == 0:
            return out
        if self._raw is None:
            self._raw = self._value = int(raw[0])
        self._value = int(_extend(raw, self._raw, self._value, out))
        self._raw = int(raw[-1])
        return out

    def state(self) -> tuple[int | None, int]:
        """Return what must be given to :meth:`restore` to be here again."""
        return self._raw, self._value

    def restore(self, state: tuple[int | None, int]) -> None:
        """Go back to an earlier :meth:`state`, for a replay."""
        self._raw, self._value = state
