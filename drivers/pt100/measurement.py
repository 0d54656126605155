"""One reading of a thermometer, and what is no reading at all."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from drivers.errors import SensorError
from drivers.pt100 import iec60751


@dataclass(frozen=True, slots=True)
class Measurement:
    """A temperature as its device gave it.

    Attributes
    ----------
    temperature_c : °C.
    resistance_ohm : Ω, where the device gives resistance; None where it linearises by itself.
    conversion : the device's count of conversions, where it has one; a reading with the same count is the same reading.
    """

    temperature_c: float
    resistance_ohm: float | None = None
    conversion: int | None = None


class Thermometer(Protocol):
    """A thermometer beside the bus, which takes its time to answer."""

    name: str

    def measure(self) -> Measurement:
        """Ask the device.

        Raises
        ------
        SensorError
            If it does not answer, or says open or short circuit, or anything that is no temperature.
        """
        ...

    def close(self) -> None:
        """Let go of port or connection."""
        ...


@dataclass(frozen=True, slots=True)
class Range:
    """What a thermometer can be asked to believe.

    Attributes
    ----------
    lowest_c, highest_c : plausible temperatures at its place, °C.
    short_below_ohm, open_above_ohm : resistances (of a PT100; a PT1000 is ten times that) that are faults.
    """

    lowest_c: float = -50.0
    highest_c: float = 200.0
    short_below_ohm: float = 60.0
    open_above_ohm: float = 300.0


def from_resistance(
    name: str, ohm: float, limits: Range, r0: float = 100.0, conversion: int | None = None
) -> Measurement:
    """Temperature of a resistance by IEC 60751.

    Raises
    ------
    SensorError
        On a short or open circuit, or a temperature outside what is plausible.
    """
    if not math.isfinite(ohm) or ohm > limits.open_above_ohm * r0 / 100.0:
        raise SensorError(f"{name}: open circuit ({ohm:.4g} Ω); check sensor and wires")
    if ohm < limits.short_below_ohm * r0 / 100.0:
        raise SensorError(f"{name}: short circuit ({ohm:.4g} Ω); check sensor and wires")
    return from_temperature(name, float(iec60751.temperature(ohm, r0)), limits, ohm, conversion)


def from_temperature(
    name: str, temperature_c: float, limits: Range, ohm: float | None = None, conversion: int | None = None
) -> Measurement:
    """Take a temperature the device has linearised.

    Raises
    ------
    SensorError
        Where it is outside what is plausible: devices report open and short circuits as very high and very low values.
    """
    if not limits.lowest_c <= temperature_c <= limits.highest_c:
        raise SensorError(
            f"{name}: {temperature_c:.4g} °C is outside the plausible {limits.lowest_c:g} to {limits.highest_c:g} °C; "
            "check sensor, wires and the device's setting"
        )
    return Measurement(temperature_c, ohm, conversion)
