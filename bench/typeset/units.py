"""Units people at a bench use: µrad, mN·m; what is computed with stays SI."""

from __future__ import annotations

import math

ENGINEERING: dict[str, tuple[str, float]] = {
    "rad": ("µrad", 1e6),
    "N*m": ("mN·m", 1e3),
    "N*m*s/rad": ("mN·m·s/rad", 1e3),
    "N*m*s/(rad*K)": ("µN·m·s/(rad·K)", 1e6),
    "kg*m^2": ("g·m²", 1e3),
    "J/K": ("kJ/K", 1e-3),
    "rad/(N*m)": ("µrad/(N·m)", 1e6),
    "rad/K": ("µrad/K", 1e6),
    "rad/s": ("µrad/s", 1e6),
    "degC": ("°C", 1.0),
    "1": ("", 1.0),
}
"""SI unit as files write it: the unit for people, and how many of it are in an SI unit."""
LARGE = {"N*m": ("N·m", 1.0), "kg*m^2": ("kg·m²", 1.0)}
"""In place of the unit above from 10 of the SI unit on."""
_LARGE_FROM = 10.0


def engineering(value: float, std: float | None, unit: str) -> tuple[str, str, str]:
    """Return value, standard deviation and unit as texts; what is not known is a dash, never ``nan``."""
    name, scale = ENGINEERING.get(unit, (plain(unit), 1.0))
    if unit in LARGE and abs(value) >= _LARGE_FROM:
        name, scale = LARGE[unit]
    spread = "–" if std is None or not math.isfinite(std) else f"{std * scale:.2g}"
    return figure(value * scale), spread, name


def figure(value: float, form: str = ".4g") -> str:
    """Return a number, a dash where there is none."""
    return f"{value:{form}}" if math.isfinite(value) else "–"


def plain(unit: str) -> str:
    """Return a unit as people write it: ``N*m^2`` as N·m²."""
    return unit.replace("*", "·").replace("^2", "²").replace("degC", "°C")
