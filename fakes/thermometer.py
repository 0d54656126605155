"""What a PT100 transmitter of the emulated bench measures: resistance and temperature of the element at this moment.

Modbus and serial devices ask a source when they are asked themselves; the source is the plant's reading, handed over by
whoever runs the plant. They run in real time (a fast emulated campaign reads its PT100 through the EtherCAT terminal).
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Protocol

from fakes.pt100 import Wiring, measured_resistance, wiring_of

CONVERSION_S = 0.1
"""Time between conversions of a transmitter."""


class Source(Protocol):
    """Where readings come from."""

    def celsius(self, channel: int) -> float:
        """Return the PT100 reading of a channel in °C (0 lubricant, 1 surroundings); ±10 000 where open or short."""
        ...


@dataclass(slots=True)
class FixedSource:
    """Readings that stay until they are set, for tests."""

    lubricant: float = 20.0
    ambient: float = 21.0

    def celsius(self, channel: int) -> float:
        """Return the reading of a channel in °C."""
        return self.ambient if channel else self.lubricant


@dataclass(frozen=True, slots=True)
class Reading:
    """One conversion: °C and Ω (infinite where open, 0 where short), wiring, running number."""

    celsius: float
    ohm: float
    wiring: Wiring
    conversion: int


@dataclass(slots=True)
class Transmitter:
    """One channel with the wiring faults a transmitter sees; ``wiring`` overrides what the source says."""

    source: Source
    channel: int = 0
    wiring: Wiring = Wiring.GOOD

    def read(self) -> Reading:
        """Return the present conversion."""
        celsius = self.source.celsius(self.channel)
        wiring = self.wiring if self.wiring is not Wiring.GOOD else wiring_of(celsius)
        conversion = int(time.monotonic() / CONVERSION_S) & 0xFFFF
        return Reading(celsius, measured_resistance(celsius, wiring), wiring, conversion)
