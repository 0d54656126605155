"""EtherCAT terminal for resistance thermometers: entry point ``pt100_terminal`` of the group ``bench.drivers``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from drivers import analog
from drivers.devices import Place, build
from drivers.entries import Entry, entry_name
from drivers.errors import DriverError
from drivers.ethercat.sdo import SdoClient
from drivers.ethercat.slave import Pdo, SlaveSpec
from drivers.pt100 import iec60751
from drivers.pt100.measurement import Range

Element = Literal["temperature", "temperature_hundredths", "resistance_sixteenths", "resistance_sixty_fourths"]

SETTINGS: dict[Element, tuple[int, int, float]] = {
    "temperature": (0, 0, 0.1),
    "temperature_hundredths": (0, 2, 0.01),
    "resistance_sixteenths": (8, 0, 1.0 / 16.0),
    "resistance_sixty_fourths": (9, 0, 1.0 / 64.0),
}
"""Presentation: element (0x80n0:19), resolution (0x80n0:02), °C or Ω a count."""


@dataclass(frozen=True, slots=True)
class ChannelBlock:
    """One channel over one block.

    Attributes
    ----------
    raw : counts (n,) as the terminal gave them.
    temperature_c : (n,) °C; NaN where the reading is no temperature.
    valid : mask (n,).
    age_s : (n,) time since the terminal's last conversion, s.
    error : sentence on the last reading; None where it is valid.
    """

    raw: NDArray[np.int16]
    temperature_c: NDArray[np.float64]
    valid: NDArray[np.bool_]
    age_s: NDArray[np.float64]
    error: str | None


@dataclass(slots=True)
class Pt100Terminal:
    """Terminal with one or more channels of status word and value.

    Parameters
    ----------
    place : where it is and what it must be.
    channels : channels that are used, from 1.
    element : what the terminal should give.
    limits : what is plausible.
    r0 : resistance at 0 °C, Ω, where it gives resistance.
    """

    place: Place
    channels: int = 1
    element: Element = "temperature"
    limits: Range = field(default_factory=Range)
    r0: float = 100.0
    _inputs: NDArray[Any] | None = None
    _toggles: dict[int, int] = field(default_factory=dict)
    _ages: dict[int, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse an element that does not exist, where the sentence can name the terminal."""
        if self.element not in SETTINGS:
            raise DriverError(
                f"{self.place.name}: element '{self.element}' is not known; one of {', '.join(SETTINGS)} is"
            )

    @property
    def spec(self) -> SlaveSpec:
        """The slave as the bus should find it."""
        place = self.place
        pdos = tuple(
            Pdo(
                0x1A00 + channel,
                (Entry(entry_name(_object(channel), 0x01), "u2"), Entry(entry_name(_object(channel), 0x11), "i2")),
                fixed=True,
            )
            for channel in range(self.channels)
        )
        return SlaveSpec(
            place.name,
            place.position,
            place.vendor,
            place.product,
            tx_pdos=pdos,
            revision=place.revision,
            configure=self.configure,
        )

    @property
    def scale(self) -> float:
        """°C or Ω a count."""
        return SETTINGS[self.element][2]

    @property
    def dtype(self) -> str:
        """Type of a count."""
        return "int16"

    def configure(self, sdo: SdoClient) -> None:
        """Set element and resolution of every channel, read back and compared."""
        element, presentation, _ = SETTINGS[self.element]
        for channel in range(self.channels):
            sdo.write_checked(0x8000 + 0x10 * channel, 0x19, "u2", element)
            sdo.write_checked(0x8000 + 0x10 * channel, 0x02, "u1", presentation)

    def attach(self, outputs: NDArray[Any] | None, inputs: NDArray[Any] | None) -> None:
        """Take the terminal's inputs."""
        self._inputs = inputs
        self._toggles.clear()
        self._ages.clear()

    def close(self) -> None:
        """Do nothing: the terminal is on the bus, which has let go of it."""

    def read(self, n: int, channel: int = 1) -> ChannelBlock:
        """Readings of one channel over the block just exchanged; call it once a block."""
        if self._inputs is None:
            raise DriverError(f"{self.place.name} has no process data yet; attach() comes before the first cycle")
        block = self._inputs[:n]
        status = block[entry_name(_object(channel - 1), 0x01)]
        raw: NDArray[np.int16] = block[entry_name(_object(channel - 1), 0x11)]
        toggle = self._toggles.get(channel, int(status[0]) & analog.TOGGLE)
        ages = analog.ages(status, toggle, self._ages.get(channel, 0))
        self._toggles[channel], self._ages[channel] = int(status[-1]) & analog.TOGGLE, int(ages[-1])
        temperature: NDArray[np.float64] = raw.astype(np.float64) * self.scale
        if self.element.startswith("resistance"):
            temperature = iec60751.temperature(temperature, self.r0)
        plausible = (temperature >= self.limits.lowest_c) & (temperature <= self.limits.highest_c)
        valid = analog.usable(status) & plausible
        error = None if valid[-1] else self._error(int(status[-1]), float(temperature[-1]), channel)
        temperature[~valid] = np.nan
        return ChannelBlock(raw, temperature, valid, ages.astype(np.float64) * self.place.cycle_time_s, error)

    def _error(self, status: int, temperature_c: float, channel: int) -> str:
        where = f"{self.place.name}, channel {channel}"
        for bit, what in (
            (analog.OVERRANGE, "open circuit, or above the range"),
            (analog.UNDERRANGE, "short circuit, or below the range"),
            (analog.ERROR, "the terminal reports an error"),
            (analog.INVALID, "the terminal marks its value as invalid"),
        ):
            if status & bit:
                return f"{where}: {what} (status 0x{status:04X}); check sensor and wires"
        limits = self.limits
        return (
            f"{where}: {temperature_c:.4g} °C is outside the plausible {limits.lowest_c:g} to {limits.highest_c:g} °C; "
            "check sensor and wires"
        )


def _object(channel: int) -> int:
    """Input object of a channel counted from 0."""
    return 0x6000 + 0x10 * channel


def pt100_terminal(place: Place, options: Mapping[str, Any]) -> Pt100Terminal:
    """Make a thermometer terminal from a configuration file's options."""
    rest = dict(options)
    limits = build(Range, f"{place.name}, limits", rest.pop("limits", {}))
    return build(Pt100Terminal, place.name, rest, place=place, limits=limits, _inputs=None, _toggles={}, _ages={})
