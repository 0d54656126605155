"""Units as other laboratories write them, and what makes SI of them; :mod:`pint` knows them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from typing import Any

from bench.errors import ConfigurationError

_NAMES: dict[str, str] = {
    "": "dimensionless",
    "-": "dimensionless",
    "1": "dimensionless",
    "1/min": "rpm",
    "min^-1": "rpm",
    "min-1": "rpm",
    "U/min": "rpm",
    "r/min": "rpm",
    "upm": "rpm",
    "RPM": "rpm",
    "u": "revolution",
    "sec": "s",
    "Sec": "s",
    "msec": "ms",
    "S": "s",
    "°C": "degC",
    "C": "degC",
    "°F": "degF",
    "°K": "K",
    "°": "degree",
    "GradC": "degC",
    "Grad C": "degC",
    "Grad Celsius": "degC",
    "Deg": "degree",
    "Ohm": "ohm",
    "g": "gram",
    "g0": "standard_gravity",
    "Hz": "Hz",
}
"""Spellings that pint does not know, or takes for something else."""
_GERMAN: dict[str, tuple[str, ...]] = {
    "degree": ("grad",),  # pint takes "grad" for gon and "Grad" for a thousand million rad
    "revolution": ("umdrehungen", "umdrehung", "umdr"),
    "count": ("inkremente", "inkrement", "inkr"),
    "s": ("sekunden", "sekunde", "sek"),
    "ms": ("millisekunden", "millisekunde"),
    "min": ("minuten", "minute"),
}
"""German words by what pint calls them, in small letters; they are read in any case."""
_GERMAN_WORDS = {word: unit for unit, words in _GERMAN.items() for word in words}
_GERMAN_WORD = re.compile(rf"\b({'|'.join(_GERMAN_WORDS)})\b\.?", re.IGNORECASE)

_SI: tuple[str, ...] = (
    "rad", "rad/s", "rad/s**2", "m", "m/s", "m/s**2", "s", "N", "N*m", "kg", "A", "V", "W", "Pa", "Hz", "ohm", "T",
    "kg*m**2", "N*s/m", "N*m*s/rad", "N/m", "N*m/rad", "m**3/s", "kg/s", "N*m/s", "N/s", "V*s/rad",
)  # fmt: skip
"""What quantities are kept in, where no channel says it."""

_SHOWN = {"N*m": "N·m", "ohm": "Ω", "degC": "°C", "delta_degC": "K", "dimensionless": "1"}
_TEMPERATURES = ("kelvin", "degree_Celsius", "degree_Fahrenheit", "degree_Rankine")
_AS_ANGULAR = {"1/s", "Hz"}
_BRACKETS = re.compile(
    r"^(?P<name>.*?)\s*(?:\[(?P<a>[^\[\]]*)\]|\((?P<b>[^()]*)\)|\s/\s*(?P<c>\S+)|\s+in\s+(?P<d>\S+))\s*$"
)
PERCENT = "%"
"""of something that the file does not hold, such as the rated torque"""
_SYMBOLS = {
    **{unit: unit for unit in ("deg", "rad", "rpm", "Nm", "N", "kN", "MN", "A", "mA", "V", "s", "ms", "us", "degC")},
    **{unit: unit for unit in ("um", "mm", "cm", "m", "counts")},
    "C": "degC",
}
"""units at the end of a name that are told apart by small and capital letters"""
_AT_THE_END: dict[str, tuple[str, ...]] = {
    "deg": ("deg", "degrees", "grad"),
    "rad": ("rad", "radians"),
    "rev": ("revs", "turns", "revolutions", "umdr", "umdrehungen"),
    "counts": ("counts", "ticks", "increments", "inkr", "inkremente"),
    "s": ("sec", "seconds", "sek", "sekunden"),
    "ms": ("msec", "milliseconds", "millisekunden"),
    "degC": ("degc", "gradc", "grad_c", "celsius", "grad_celsius"),
    "rpm": ("rpm", "upm", "umin", "u_min", "u/min", "1_min", "1/min", "r_min"),
    "deg/s": ("degs", "degps", "dps"),
    "rad/s": ("rads", "radps"),
    "rev/s": ("rps", "revps"),
    "m/s": ("mps",),
    "mm/s": ("mmps",),
}
"""units as words at the end of a name, in small letters; they are read in any case"""
_OF_WAY: dict[str, tuple[str, ...]] = {
    "deg": ("deg", "degree", "degrees", "grad"),
    "rad": ("rad", "radian", "radians"),
    "rev": ("rev", "revs", "turn", "turns", "revolutions", "umdr", "umdrehungen"),
    "counts": ("counts", "cts", "inc", "increments", "ticks", "inkr", "inkremente"),
    "m": ("m",),
    "cm": ("cm",),
    "mm": ("mm",),
    "um": ("um",),
}
_OF_TIME: dict[str, tuple[str, ...]] = {
    "s": ("s", "sec", "second", "sek", "sekunde"),
    "min": ("min", "minute"),
}
_PER = ("_", "/", "_per_", "_pro_", "per")
_WORDS = {
    **{
        f"{way}{per}{time}": f"{unit}/{duration}"
        for unit, ways in _OF_WAY.items()
        for duration, times in _OF_TIME.items()
        for way in ways
        for per in _PER
        for time in times
    },
    **{word: unit for unit, words in _AT_THE_END.items() for word in words},
}
_SUFFIX = re.compile(
    rf"^(?P<name>.+?)_(?:(?P<symbol>{'|'.join(_SYMBOLS)})|(?P<word>(?i:{'|'.join(map(re.escape, _WORDS))})))$"
)
"""the longest unit at the end of a name: a speed in ``turns_s`` is in no seconds"""


@dataclass(frozen=True, slots=True)
class Unit:
    """SI value = value · ``factor`` + ``offset``, in ``si`` (temperatures in °C, as the recording format has them)."""

    si: str
    factor: float = 1.0
    offset: float = 0.0


@cache
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry(cache_folder=None, on_redefinition="ignore")
    registry.define("@alias revolution = rev = revs = revolutions")
    registry.define("@alias count = inc = incs = increment = increments = tick = ticks = cts = cnt = counts")
    return registry


def _pint_spelling(name: str) -> str:
    """A spelling pint reads: products with a mark between, powers and signs of degrees as it knows them."""
    text = _NAMES.get(name.strip(), name.strip())
    text = text.replace("·", "*").replace("⋅", "*").replace("•", "*").replace("μ", "µ").replace("^", "**")
    text = re.sub(r"(?<![A-Za-zµ°])(da|[mkMGµucd]?)N[ -]?([cm]?)m(?=s?(?![A-Za-z]))", r"\1N*\2m", text)
    text = re.sub(r"(?<=N\*m)s(?![A-Za-z])", "*s", text)
    text = re.sub(r"°(?![CFK])", "degree", text)
    text = re.sub(r"\s+pro\s+", "/", _GERMAN_WORD.sub(lambda match: _GERMAN_WORDS[match[1].lower()], text))
    text = text.replace("°C", "degC").replace("°F", "degF").replace("°K", "K")
    return re.sub(r"\bU(?=/)", "revolution", text)


def _modelica(name: str) -> str:
    """A unit as Modelica and FMI write it, with dots for products and bare digits for powers: ``kg.m2``, ``rad/s2``."""
    return re.sub(r"(?<=[A-Za-z])(-?\d)", r"**\1", re.sub(r"(?<=[A-Za-z0-9])\.(?=[A-Za-z])", "*", name))


@cache
def _parse_unit(name: str) -> Any:
    """The unit pint makes of a name, or None."""
    plain, modelica = _pint_spelling(name), _pint_spelling(_modelica(name))
    unit = _of_pint(plain)
    return _of_pint(modelica) if unit is None and modelica != plain else unit


def _of_pint(text: str) -> Any:
    import pint

    try:
        return _registry().Unit(text)
    except (pint.errors.PintError, ValueError, TypeError, AttributeError, KeyError, SyntaxError, AssertionError):
        return None
    except Exception as error:
        if type(error).__module__.startswith(("tokenize", "pint")):
            return None
        raise


def is_unit(name: str) -> bool:
    """Whether a text is a unit."""
    return bool(name) and not name.isdigit() and _parse_unit(name) is not None


def split_unit(heading: str) -> tuple[str, str]:
    """Split a heading such as ``Torque [N·m]``, ``speed (rpm)``, ``angle / deg`` or ``vel_deg_s`` into name and unit;
    the unit is empty where there is none.
    """
    match = _BRACKETS.match(heading)
    if match:
        unit = next((group for group in match.group("a", "b", "c", "d") if group is not None), "").strip()
        if unit.startswith(PERCENT):
            return match["name"], PERCENT  # "% rated" says of what
        if is_unit(unit) or (match["a"] is not None and unit in ("-", "")):
            return match["name"], unit
    match = _SUFFIX.match(heading)
    if match:
        return match["name"], _SYMBOLS[match["symbol"]] if match["symbol"] else _WORDS[match["word"].lower()]
    return heading, ""


def unit_of(name: str, where: str, like: str | None = None) -> Unit:
    """Say what makes SI of a unit.

    Parameters
    ----------
    where : file and key, for the sentence of an error.
    like : SI unit of the channel it is meant for; None: whatever SI unit fits.

    Raises
    ------
    ConfigurationError
        The unit is not known, or is none of that quantity.
    """
    unit = _parse_unit(name)
    if unit is None:
        raise ConfigurationError(
            f"{where}: unit '{name}' is not known; 'deg', 'rpm', 'cm/s', 'N*m', 'mA', 'degC', 'counts' are such."
        )
    target = _target(name, unit, like)
    if target is None:
        meant = _meant(name, like)
        near = f"; did you mean '{meant}'?" if meant else "."
        raise ConfigurationError(f"{where}: unit '{name}' should be one that becomes '{like}'{near}")
    registry = _registry()
    # a rate of 1/s or Hz that is meant as a speed counts revolutions
    turning = like == "rad/s" and str(registry.get_base_units(unit)[1]) == "1 / second"
    unit = unit * registry.revolution if turning else unit
    zero = float(registry.Quantity(0.0, unit).to(target).magnitude)
    one = float(registry.Quantity(1.0, unit).to(target).magnitude)
    return Unit(_SHOWN.get(target, target).replace("**2", "²").replace("**3", "³").replace("*", "·"), one - zero, zero)


def _meant(name: str, like: str | None) -> str:
    """A rate that was written as a product (``rad.s`` for rad/s), where it makes the unit that is wanted; or empty."""
    rate = re.sub(r"^(\w+)[.*·](s|sec|min)$", r"\1/\2", name.strip())
    unit = _parse_unit(rate) if rate != name.strip() else None
    return rate if unit is not None and _target(rate, unit, like) is not None else ""


def si_of(name: str) -> str:
    """SI unit that a unit becomes; "" where it is none."""
    try:
        return unit_of(name, "").si if name else ""
    except ConfigurationError:
        return ""


def _target(name: str, unit: Any, like: str | None) -> str | None:
    """The SI unit, as pint spells it, that a unit becomes; None where it is not of the quantity ``like``."""
    registry = _registry()
    base = str(registry.get_base_units(unit)[1])
    if len(unit._units) == 1 and next(iter(unit._units)) in _TEMPERATURES:
        return "degC" if like in (None, "°C") else None
    if like is None:
        fits = (si for si in _SI if str(registry.get_base_units(registry.Unit(si))[1]) == base)
        return next(
            fits, "dimensionless" if base in ("dimensionless", "count") else f"{registry.get_base_units(unit)[1]:~P}"
        )
    wanted = like.replace("·", "*").replace("°C", "degC").replace("1", "dimensionless")
    target = str(registry.get_base_units(registry.Unit(wanted))[1])
    angular = like == "rad/s" and base == "1 / second"
    counted = like == "1" and base == "count"
    return wanted if target == base or angular or counted or _same_but_radians(registry, target, base) else None


def _same_but_radians(registry: Any, target: str, base: str) -> bool:
    """Whether two base units are the same but for radians in a torque (N·m/rad · rad)."""
    if "radian" in target:
        return False
    return target == base.replace(" * radian", "").replace("radian * ", "").replace(" / radian", "")


def quantity(text: str, where: str) -> tuple[float, str]:
    """Split ``0.12 N*m/A`` into number and unit.

    Raises
    ------
    ConfigurationError
        It is not a number with a unit.
    """
    match = re.fullmatch(r"\s*([+-]?[0-9.]+(?:[eE][+-]?\d+)?)\s*(\S.*?)?\s*", text)
    try:
        number = float(match[1]) if match else None
    except ValueError:
        number = None
    if match is None or number is None or not is_unit(match[2] or "dimensionless"):
        raise ConfigurationError(f"{where}: '{text}' should be a number with a unit, such as '0.12 N*m/A'.")
    return number, match[2] or "1"


def product_unit(first: str, second: str) -> str:
    """Name the product of two units."""
    return f"({_pint_spelling(first)})*({_pint_spelling(second)})"
