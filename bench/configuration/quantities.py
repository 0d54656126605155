"""Values with units, as an operator writes them: ``"10 kN*m"``, ``"2.5 deg/s"``, ``"50 degC"``.

Inside the program everything is SI (temperatures in °C); only here, at the edge, other units are understood. A bare
number is refused, because a reader of the file could not know what it means.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Annotated

from pydantic import BeforeValidator

from bench.protocols import Unit

_REVOLUTION = 2.0 * math.pi
_DEGREE = _REVOLUTION / 360.0

UNITS: dict[str, dict[str, float]] = {
    "torque": {"N*m": 1.0, "Nm": 1.0, "mN*m": 1e-3, "kN*m": 1e3, "kNm": 1e3},
    "torque rate": {"N*m/s": 1.0, "kN*m/s": 1e3},
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": _DEGREE, "°": _DEGREE, "rev": _REVOLUTION},
    "speed": {"rad/s": 1.0, "deg/s": _DEGREE, "°/s": _DEGREE, "rpm": _REVOLUTION / 60.0, "1/min": _REVOLUTION / 60.0},
    "acceleration": {"rad/s^2": 1.0, "deg/s^2": _DEGREE},
    "time": {"s": 1.0, "us": 1e-6, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    "temperature": {"degC": 1.0, "°C": 1.0},
    "temperature difference": {"K": 1.0},
    "inertia": {"kg*m^2": 1.0},
    "stiffness": {"N*m/rad": 1.0, "kN*m/rad": 1e3, "MN*m/rad": 1e6},
    "heat capacity": {"J/K": 1.0, "kJ/K": 1e3},
    "thermal resistance": {"K/W": 1.0},
    "viscous friction": {"N*m*s/rad": 1.0},
    "viscous friction change": {"N*m*s/(rad*K)": 1.0},
    "voltage": {"V": 1.0, "mV": 1e-3},
    "power": {"W": 1.0, "kW": 1e3},
    "ratio": {"1": 1.0, "%": 0.01},
    "time constant ratio": {"1/s": 1.0},
    "size": {"B": 1.0, "MB": 1e6, "GB": 1e9},
}
"""Every unit an operator may write, by kind of quantity, with the factor to SI."""

_EXAMPLES: dict[str, str] = {
    "torque": "10 kN*m",
    "speed": "2.5 deg/s",
    "temperature": "50 degC",
    "temperature difference": "1 K",
    "time": "0.5 ms",
    "angle": "30 deg",
}

_PATTERN = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*?)\s*$")


def parse_quantity(text: object, kind: str) -> float:
    """Read a value with its unit and return it in SI.

    Raises
    ------
    ValueError
        If the text is not a number followed by a unit of this kind; the message says what would be right.

    Examples
    --------
    >>> parse_quantity("10 kN*m", "torque")
    10000.0
    """
    units = UNITS[kind]
    example = _EXAMPLES.get(kind, f"1 {next(iter(units))}")
    if isinstance(text, int | float) and not isinstance(text, bool):
        raise ValueError(f'a {kind} needs its unit; write a text such as "{example}"')
    match = _PATTERN.match(text) if isinstance(text, str) else None
    if match is None:
        raise ValueError(f'this is not a {kind}; write a number and its unit, such as "{example}"')
    number, unit = float(match.group(1)), match.group(2)
    if unit not in units:
        raise ValueError(f'"{unit}" is not a unit of {kind}; use one of {", ".join(units)}')
    value = number * units[unit]
    if not math.isfinite(value):
        raise ValueError(f"the value is too large for a {kind}")
    return value


def _reader(kind: str) -> Callable[[object], float]:
    def read(value: object) -> float:
        return parse_quantity(value, kind)

    return read


Torque = Annotated[float, BeforeValidator(_reader("torque")), Unit("torque")]
TorqueRate = Annotated[float, BeforeValidator(_reader("torque rate")), Unit("torque rate")]
Angle = Annotated[float, BeforeValidator(_reader("angle")), Unit("angle")]
Speed = Annotated[float, BeforeValidator(_reader("speed")), Unit("speed")]
Acceleration = Annotated[float, BeforeValidator(_reader("acceleration")), Unit("acceleration")]
Time = Annotated[float, BeforeValidator(_reader("time")), Unit("time")]
Temperature = Annotated[float, BeforeValidator(_reader("temperature")), Unit("temperature")]
TemperatureDifference = Annotated[
    float, BeforeValidator(_reader("temperature difference")), Unit("temperature difference")
]
Inertia = Annotated[float, BeforeValidator(_reader("inertia")), Unit("inertia")]
Stiffness = Annotated[float, BeforeValidator(_reader("stiffness")), Unit("stiffness")]
HeatCapacity = Annotated[float, BeforeValidator(_reader("heat capacity")), Unit("heat capacity")]
ThermalResistance = Annotated[float, BeforeValidator(_reader("thermal resistance")), Unit("thermal resistance")]
Viscous = Annotated[float, BeforeValidator(_reader("viscous friction")), Unit("viscous friction")]
ViscousChange = Annotated[float, BeforeValidator(_reader("viscous friction change")), Unit("viscous friction change")]
Voltage = Annotated[float, BeforeValidator(_reader("voltage")), Unit("voltage")]
Ratio = Annotated[float, BeforeValidator(_reader("ratio")), Unit("ratio")]
Power = Annotated[float, BeforeValidator(_reader("power")), Unit("power")]
Size = Annotated[float, BeforeValidator(_reader("size")), Unit("size")]
