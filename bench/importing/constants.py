"""``scale`` and ``offset`` of a column: numbers, variables of the file that hold one, and an offset with its unit."""

from __future__ import annotations

import re

from bench.errors import ConfigurationError
from bench.importing.formats import Source
from bench.importing.units import Unit, quantity, si_of, unit_of

_NUMBER = re.compile(r"\s*[+-]?\.?\d")
"""begins an offset that is a number with a unit, and not the name of a variable"""


def constant(value: float | str, source: Source, where: str, key: str) -> float:
    """A number, or that of the variable of the file with this name.

    Raises
    ------
    ConfigurationError
        The variable holds several numbers.
    RecordingError
        There is no such variable.
    """
    if not isinstance(value, str):
        return value
    found = source.read(value)
    if found.size != 1:
        raise ConfigurationError(
            f"{where}.{key}: variable '{value}' holds {found.size} values, it should hold one; "
            "'times' multiplies sample by sample."
        )
    return float(found[0])


def offset_in_si(value: float | str, source: Source, where: str, file_unit: str, made: Unit) -> float:
    """What an offset adds to a channel in its SI unit: a number is in the unit of the file, as the scaled values are; a
    text such as ``-180 deg`` is in that or in any unit of the channel.

    Parameters
    ----------
    file_unit : that of the scaled values.
    made : what makes SI of the scaled values, conversions such as ``torque_constant`` with it.

    Raises
    ------
    ConfigurationError, RecordingError
        As :func:`constant`, or its unit is neither that of the file nor that of the channel.
    """
    if not isinstance(value, str) or not _NUMBER.match(value):
        return constant(value, source, where, "offset") * made.factor
    number, text = quantity(value, f"{where}.offset")
    in_file = 1.0 if text == "1" else _ratio(text, file_unit)
    if in_file is not None:
        return number * in_file * made.factor
    return number * unit_of(text, f"{where}.offset", made.si).factor


def _ratio(one: str, other: str) -> float | None:
    """How many of another unit one is; None where they are of other quantities."""
    if si_of(one) != si_of(other):
        return None
    factors = [unit_of(unit, "").factor for unit in (one, other)]
    # counts and per cent are both without a unit, and none is made of the other
    return None if si_of(one) == "1" and factors[0] != factors[1] else factors[0] / factors[1]
