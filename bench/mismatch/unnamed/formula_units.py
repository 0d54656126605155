"""Units of a formula's constants: products and powers of units as texts such as ``N*m*s/rad``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from bench.simulation.composed import FUNCTIONS
from bench.simulation.quantities import AUXILIARY, QUANTITIES

Powers = dict[str, int]
_PARTS = re.compile(r"([*/]?)\s*([^*/^\s]+)(?:\^(-?\d+))?")
_DIFFERENCES = {"degC": "K"}
"""scales with a zero of their own: a constant is a difference on them"""
_RATES = {"rate": 1, "acceleration": 2}
_NO_UNIT = ("1", "", "log10 rad", "log10 s")


def powers(unit: str) -> Powers:
    """A unit as powers of its parts; of a text that is no product nothing."""
    if unit in _NO_UNIT or " of " in unit:
        return {}
    out: Powers = {}
    for sign, part, power in _PARTS.findall(unit.replace("²", "^2").replace("·", "*").replace("°C", "degC")):
        name = _DIFFERENCES.get(part, part)
        if name != "1":
            out[name] = out.get(name, 0) + (-1 if sign == "/" else 1) * int(power or 1)
    return {name: power for name, power in out.items() if power}


def product(parts: Iterable[tuple[str, int]]) -> str:
    """The product of units, each to a power; 1 where they cancel."""
    total: Powers = {}
    for unit, power in parts:
        for name, exponent in powers(unit).items():
            total[name] = total.get(name, 0) + power * exponent
    above = [_to(name, power) for name, power in total.items() if power > 0]
    below = [_to(name, -power) for name, power in total.items() if power < 0]
    return "*".join(above or ["1"]) + "".join(f"/{part}" for part in below)


def _to(name: str, power: int) -> str:
    return name if power == 1 else f"{name}^{power}"


def unit_of(name: str, auxiliary: Mapping[str, str]) -> str:
    """Unit of a quantity; ``auxiliary``: units of what was recorded beside the bench, by name without ``aux/``."""
    if name in QUANTITIES:
        return product([(QUANTITIES[name].unit, 1)])
    plain = name.removeprefix(AUXILIARY)
    if plain in auxiliary:
        return product([(auxiliary[plain], 1)])
    function, _, rest = plain.removesuffix(")").partition("(")
    if function not in FUNCTIONS:
        return "1"
    parts = [(auxiliary.get(part, "1"), 1) for part in rest.split(", ")]
    if function in ("cos", "sin", "sign"):
        return "1"
    if function in ("momentum", "carried"):
        return "rad/s^2"
    return product([*parts, ("s", -_RATES.get(function, 0))])


__all__ = ["powers", "product", "unit_of"]
