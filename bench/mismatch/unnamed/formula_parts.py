"""A sum as the parts of a formula: expressions of the recorded quantities, with constants that carry units.

Whatever stands inside a function is without a unit: each quantity there is divided by a constant of its own unit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from bench.mismatch.unnamed.formula_algebra import ONE, Atom, Monomial, Sum
from bench.mismatch.unnamed.formula_units import product


@dataclass(frozen=True, slots=True)
class Constant:
    """A number inside a formula; ``positive``: a scale, which keeps its sign; ``std`` None where it is not known;
    ``size``: how large numbers of its kind are.
    """

    symbol: str
    value: float
    unit: str
    positive: bool = True
    std: float | None = None
    size: float = 1.0


@dataclass(slots=True)
class Parts:
    """Expressions of a formula's parts with the unit of each, and the constants in them."""

    texts: list[str] = field(default_factory=list)
    units: list[str] = field(default_factory=list)
    constants: list[Constant] = field(default_factory=list)
    inside: dict[object, str] = field(default_factory=dict, repr=False)
    """what stands inside functions: the same argument has the same constants everywhere"""


@dataclass(frozen=True, slots=True)
class Quantities:
    """The quantities of a sum: the name of each in the formula, the scale it was divided by, its unit."""

    names: Sequence[str]
    scales: Sequence[float]
    units: Sequence[str]


def parts_of(terms: Sum, of: Quantities, begun: int = 0) -> Parts:
    """Every part of a sum; constants are numbered on from ``begun``."""
    out = Parts()
    for monomial in sorted(terms, key=lambda m: (len(repr(m)), repr(m))):
        above = [_factor(atom, p, of, out, begun) for atom, p in monomial if p > 0 and atom[:2] != ("f", "inv")]
        below = [_factor(atom, -p, of, out, begun) for atom, p in monomial if p < 0 and atom[:2] != ("f", "inv")]
        below += [_factor(atom, p, of, out, begun) for atom, p in monomial if p > 0 and atom[:2] == ("f", "inv")]
        out.texts.append("*".join(above or ["1"]) + "".join(f"/{part}" for part in below))
        out.units.append(product((of.units[int(str(a[1]))], p) for a, p in monomial if a[0] != "f"))
    return out


def _factor(atom: Atom, power: int, of: Quantities, out: Parts, begun: int) -> str:
    name = of.names[int(str(atom[1]))] if atom[0] != "f" else ""
    if atom[0] == "x":
        text = name
    elif atom[0] == "abs":
        text = f"abs({name})"
    else:
        inner = _inner(atom, of, out, begun)
        text = f"(1 {inner if inner.startswith('-') else f'+ {inner}'})" if atom[1] == "inv" else f"{atom[1]}({inner})"
        text = text.replace("(1 -", "(1 - ") if atom[1] == "inv" else text
    return text if power == 1 else f"{text}**{power}"


def _inner(atom: Atom, of: Quantities, out: Parts, begun: int) -> str:
    if atom[2] not in out.inside:
        out.inside[atom[2]] = _new(atom, of, out, begun)
    return out.inside[atom[2]]


def _new(atom: Atom, of: Quantities, out: Parts, begun: int) -> str:
    peak = _peak(atom, of, out, begun)
    if peak:
        return peak
    texts = []
    for monomial, coefficient in atom[2]:  # type: ignore[attr-defined]
        number = begun + len(out.constants) + 1
        if monomial == ONE:
            out.constants.append(Constant(f"b{number}", coefficient, "1", positive=False))
            texts.append(f"+ b{number}")
            continue
        scale, unit = _scale(monomial, of)
        square = len(monomial) == 1 and monomial[0][1] == 2
        size = (scale / abs(coefficient)) ** 0.5 if square else scale / abs(coefficient)
        squared = of.names[int(str(monomial[0][0][1]))] if square else ""
        text = f"({squared}/s{number})**2" if square else f"{_plain(monomial, of)}/s{number}"
        out.constants.append(Constant(f"s{number}", size, product([(unit, 1)]) if not square else _half(monomial, of)))
        texts.append(("+ " if coefficient > 0 else "- ") + text)
    joined = " ".join(texts)
    return joined.removeprefix("+ ") if joined.startswith("+") else "-" + joined.removeprefix("- ")


def _peak(atom: Atom, of: Quantities, out: Parts, begun: int) -> str:
    """The exponent of a peak over one quantity: its place and its width say more than two scales. Empty for others."""
    inner = dict(atom[2])  # type: ignore[call-overload]
    (first, *_), *_ = sorted(inner, key=len, reverse=True)
    single, double = ((first[0], 1),), ((first[0], 2),)
    if atom[1] != "exp" or set(inner) != {single, double} or inner[double] >= 0.0 or first[0][0] != "x":
        return ""
    number, i = begun + len(out.constants) + 1, int(first[0][1])
    scale, unit = of.scales[i], of.units[i]
    centre, width = -0.5 * inner[single] / inner[double] * scale, scale / (-inner[double]) ** 0.5
    out.constants.append(Constant(f"m{number}", centre, unit, positive=False, size=scale))
    out.constants.append(Constant(f"s{number + 1}", width, unit))
    return f"-(({of.names[i]} - m{number})/s{number + 1})**2"


def _half(monomial: Monomial, of: Quantities) -> str:
    return of.units[int(str(monomial[0][0][1]))]


def _scale(monomial: Monomial, of: Quantities) -> tuple[float, str]:
    """What a product of scaled quantities was divided by, and its unit."""
    scale = 1.0
    for atom, power in monomial:
        scale *= of.scales[int(str(atom[1]))] ** power
    return scale, product((of.units[int(str(atom[1]))], power) for atom, power in monomial)


def _plain(monomial: Monomial, of: Quantities) -> str:
    above: list[str] = []
    below: list[str] = []
    for atom, power in monomial:
        name = of.names[int(str(atom[1]))]
        text = name if atom[0] == "x" else f"abs({name})"
        (above if power > 0 else below).append(text if abs(power) == 1 else f"{text}**{abs(power)}")
    return "*".join(above or ["1"]) + "".join(f"/{part}" for part in below)
