"""Headings of flat tables, in which a ``/`` without spaces stands between a quantity and its unit: ``torque/V``."""

from __future__ import annotations

import re

from bench.importing.units import is_unit, split_unit

_LETTERS = "smhgAVNWKJC"
"""letters that are read as a unit after a ``/``: of what columns are in. Others (``t``, ``T``, ``F``, ``a``) are units
as well, and far oftener names in a group."""

_OF_A_RATE = (
    *("1", "U", "r", "u", "rev", "deg", "rad", "count", "counts", "cts", "inc"),
    *("m", "mm", "cm", "um", "km", "l", "g", "kg", "N", "mN", "kN", "MN", "Nm"),
    *("V", "mV", "A", "mA", "J", "W", "kW", "K", "Pa", "bar"),
)
"""units that a ratio begins with, where a heading is a unit and nothing else: ``deg/s``, ``U/min``, ``1/min``"""

_TIMES = ("s", "ms", "us", "sec", "min", "h")
"""what the ratios of one letter are over: ``m/s``, ``V/s``, ``l/min``. Over anything else it is a symbol: ``F/N``."""

_RATE = re.compile(r"(?:(?P<name>.*\S)[\s_-]+)?(?P<rate>[^\s_/-]+/\S+)\s*$")
"""a ratio at the end of a heading, or alone: ``vel m/s``"""


def split_heading(heading: str) -> tuple[str, str]:
    """Split the heading of a column into name and unit, also where only a ``/`` stands between (ISO 80000-1 has tables
    so: a quantity over its unit is a number); ``m/s`` alone is a unit, and ``v/m/s`` is a v in m/s.

    In files with groups ``group/V`` is a name: :func:`bench.importing.units.split_unit` is for those.
    """
    name, unit = split_unit(heading)
    if unit:
        return name.rstrip("/ "), unit
    rate = _RATE.match(heading)
    if rate and _is_rate(rate["rate"]):
        return (rate["name"], rate["rate"]) if rate["name"] else (heading, "")
    for slash in re.finditer("/", heading):
        name, unit = heading[: slash.start()].strip(), heading[slash.end() :].strip()
        if name and _may_follow(unit):
            return name, unit
    return heading, ""


def _may_follow(text: str) -> bool:
    """Whether a text after a ``/`` is a unit, and not the name of something in a group."""
    return is_unit(text) and not (len(text) == 1 and text.isascii() and text.isalpha() and text not in _LETTERS)


def _is_rate(text: str) -> bool:
    """Whether a text with a ``/`` is a ratio of units and has no name."""
    over, _, under = text.partition("/")
    if over not in _OF_A_RATE or not is_unit(text):
        return False
    return len(over) > 1 or not over.isalpha() or under.rstrip("²^2*") in _TIMES
