"""Units as other laboratories write them, and what makes SI of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bench.errors import ConfigurationError

_DEGREE = math.pi / 180


@dataclass(frozen=True, slots=True)
class Unit:
    """SI value = value · ``factor`` + ``offset``, in ``si`` (temperatures in °C, as the recording format has them)."""

    si: str
    factor: float = 1.0
    offset: float = 0.0


UNITS: dict[str, Unit] = {
    "1": Unit("1"),
    "s": Unit("s"),
    "ms": Unit("s", 1e-3),
    "us": Unit("s", 1e-6),
    "µs": Unit("s", 1e-6),
    "ns": Unit("s", 1e-9),
    "min": Unit("s", 60.0),
    "rad": Unit("rad"),
    "mrad": Unit("rad", 1e-3),
    "deg": Unit("rad", _DEGREE),
    "°": Unit("rad", _DEGREE),
    "arcmin": Unit("rad", _DEGREE / 60),
    "arcsec": Unit("rad", _DEGREE / 3600),
    "rev": Unit("rad", 2 * math.pi),
    "rad/s": Unit("rad/s"),
    "deg/s": Unit("rad/s", _DEGREE),
    "°/s": Unit("rad/s", _DEGREE),
    "rpm": Unit("rad/s", 2 * math.pi / 60),
    "1/min": Unit("rad/s", 2 * math.pi / 60),
    "Hz": Unit("rad/s", 2 * math.pi),
    "N·m": Unit("N·m"),
    "N*m": Unit("N·m"),
    "Nm": Unit("N·m"),
    "mN·m": Unit("N·m", 1e-3),
    "mNm": Unit("N·m", 1e-3),
    "kN·m": Unit("N·m", 1e3),
    "kNm": Unit("N·m", 1e3),
    "m": Unit("m"),
    "mm": Unit("m", 1e-3),
    "um": Unit("m", 1e-6),
    "µm": Unit("m", 1e-6),
    "m/s": Unit("m/s"),
    "mm/s": Unit("m/s", 1e-3),
    "N": Unit("N"),
    "kN": Unit("N", 1e3),
    "°C": Unit("°C"),
    "degC": Unit("°C"),
    "K": Unit("°C", 1.0, -273.15),
    "°F": Unit("°C", 5 / 9, -160 / 9),
    "V": Unit("V"),
    "mV": Unit("V", 1e-3),
    "A": Unit("A"),
    "mA": Unit("A", 1e-3),
}


def unit_of(name: str, where: str) -> Unit:
    """Look up a unit.

    Raises
    ------
    ConfigurationError
        The unit is not known; ``where`` names file and key.
    """
    try:
        return UNITS[name]
    except KeyError:
        raise ConfigurationError(f"{where}: unit '{name}' is not known; known are {', '.join(UNITS)}.") from None
