"""Encoder counts that wrap, extended to int64 by counting the overflows."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


class EncoderExtender:
    """Unwraps a counter over blocks of any length.

    Each step is taken as the shorter way round, so the shaft may turn by less than half the counter's range between two
    samples: half of 2³² counts at 2 kHz is far beyond any shaft; for a counter that wraps every revolution the limit is
    half a revolution a cycle.

    Parameters
    ----------
    modulus : counts after which the device starts again: 2³² for a full INT32 (0x6064), one revolution's counts for a
        device that reports a single turn.
    """

    def __init__(self, modulus: int = 1 << 32) -> None:
        if modulus < 2:
            raise ValueError(f"an encoder cannot wrap after {modulus} counts; at least 2 are needed")
        self._modulus = modulus
        self._last: int | None = None

    @property
    def last(self) -> int | None:
        """Last extended position, counts; None before the first sample."""
        return self._last

    def reset(self, position: int | None = None) -> None:
        """Forget the past; the next sample stands as it is read (None), or nearest to ``position`` counts."""
        self._last = position

    def extend(self, raw: ArrayLike) -> NDArray[np.int64]:
        """Return extended positions (n,) of raw counter values (n,), both in counts."""
        values = np.asarray(raw).astype(np.int64)
        if values.size == 0:
            return values
        first = int(values[0]) if self._last is None else self._last
        half = self._modulus // 2
        if values.size == 1:  # one cycle on hardware: a third of the time of the general way
            values[0] = self._last = first + (int(values[0]) - first + half) % self._modulus - half
            return values
        steps = np.diff(values, prepend=first)
        # Only the first step can span more than one range: it starts from the extended position.
        steps = (steps + half) % self._modulus - half
        extended = first + np.cumsum(steps)
        self._last = int(extended[-1])
        return extended
