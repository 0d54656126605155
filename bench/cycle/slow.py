"""A thermometer beside the bus (Modbus, serial line) in the shape of one on it: each cycle holds the last reading."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.devices import Reader

_MILLI = 1e-3
_NO_READING = np.iinfo(np.int32).min
"""Raw value where there has been no reading yet."""


@dataclass(frozen=True, slots=True)
class HeldBlock:
    """One channel over one block: raw counts in 0.001 °C, °C (NaN where invalid), age in s; all of shape (n,)."""

    raw: NDArray[np.int32]
    temperature_c: NDArray[np.float64]
    age_s: NDArray[np.float64]


class SlowThermometer:
    """Lubricant and, where there is one, ambient thermometer outside the process data."""

    scale = _MILLI
    dtype = "int32"

    def __init__(self, readers: Sequence[Reader], cycle_time_s: float) -> None:
        self._readers = readers
        self._cycle_time = cycle_time_s
        self.channels = len(readers)

    def attach(self, outputs: NDArray[Any] | None, inputs: NDArray[Any] | None) -> None:
        """Begin to read; there is no process data to attach."""
        for reader in self._readers:
            reader.start()

    def read(self, n: int, channel: int = 1) -> HeldBlock:
        """Return the last reading for each of the ``n`` cycles just exchanged, older rows with a smaller age."""
        reading = self._readers[channel - 1].latest()
        valid = reading.error is None and np.isfinite(reading.temperature_c)
        raw = round(reading.temperature_c / _MILLI) if np.isfinite(reading.temperature_c) else _NO_READING
        age = np.maximum(reading.age_s - np.arange(n)[::-1] * self._cycle_time, 0.0)
        return HeldBlock(
            np.full(n, raw, np.int32),
            np.full(n, reading.temperature_c if valid else np.nan),
            age,
        )

    def close(self) -> None:
        """Stop all readers."""
        for reader in self._readers:
            reader.close()
