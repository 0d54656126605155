"""What the bench uses of a thermometer, on the bus or beside it."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Temperatures(Protocol):
    """One channel of a thermometer over one block."""

    @property
    def raw(self) -> NDArray[Any]:
        """Counts (n,) as they are recorded."""
        ...

    @property
    def temperature_c(self) -> FloatArray:
        """°C (n,); NaN where there is no valid reading."""
        ...

    @property
    def age_s(self) -> FloatArray:
        """Age of the reading in each cycle, s (n,); ∞ where there has been none."""
        ...


class Thermometer(Protocol):
    """Lubricant (channel 1) and, where there is one, ambient thermometer (2), on the bus or beside it."""

    @property
    def scale(self) -> float:
        """°C a count."""
        ...

    @property
    def dtype(self) -> str:
        """Type of a count as it is recorded, such as int16."""
        ...

    @property
    def channels(self) -> int:
        """Number of channels."""
        ...

    def attach(self, outputs: NDArray[Any] | None, inputs: NDArray[Any] | None) -> None:
        """Take the process data, None where it has none, and begin to read."""
        ...

    def read(self, n: int, channel: int) -> Temperatures:
        """Return the readings of a channel for the n cycles just exchanged; once a block."""
        ...

    def close(self) -> None:
        """Close a device that is not on the bus."""
        ...


class Reading(Protocol):
    """The last reading of a device beside the bus."""

    @property
    def temperature_c(self) -> float:
        """°C; NaN where there has been none yet."""
        ...

    @property
    def age_s(self) -> float:
        """Time since the device was asked for it, s; ∞ where there has been none yet."""
        ...

    @property
    def error(self) -> str | None:
        """Sentence on why there is no newer one; None while all is well."""
        ...


class Reader(Protocol):
    """Asks a device beside the bus, in a thread of its own."""

    def start(self) -> None:
        """Begin to read."""
        ...

    def latest(self) -> Reading:
        """Return the last reading at once."""
        ...

    def close(self) -> None:
        """Let go of the device."""
        ...
