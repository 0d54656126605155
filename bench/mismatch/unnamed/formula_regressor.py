"""A formula as a regressor of a channel: what the search, the report and a simulation file ask of it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from bench.mismatch.regression.regressors import UNKNOWN
from bench.mismatch.unnamed.formula_parts import Constant
from bench.simulation import formulas
from bench.simulation.formulas import Formula
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import AUXILIARY, FACTOR_OF, in_words, label
from bench.simulation.reading import as_rate, left_side, of_temperature
from bench.simulation.terms import TEMPERATURE

PLAIN = {"since_reversal": "distance_since_start", "elapsed": "seconds"}
"""quantities that tables have by their order of magnitude, as formulas have them"""


@dataclass(frozen=True, slots=True)
class Equation:
    """A formula of one channel. ``units`` of its coefficients; ``constants`` with units, in the formula's order.

    In the heat balance it is a rate of the temperature, integrated over each recording.
    """

    channel: str
    formula: Formula
    units: tuple[str, ...]
    constants: tuple[Constant, ...] = ()
    effect: str = UNKNOWN

    @property
    def words(self) -> str:
        """What it is, for people."""
        of = " and ".join(label(name) for name in self.formula.over)
        times = {in_words(times) for times, _ in self.formula.parts} - {""}
        return f"a formula of {of}" + (f", times {' and '.join(sorted(times))}" if times else "")

    @property
    def equation(self) -> str:
        """Its equation."""
        groups: dict[str, list[str]] = {}
        for symbol, (times, text) in zip(self.formula.coefficients, self.formula.parts, strict=True):
            shown = re.sub(r"\bx(\d+)\b", self._shown, text).replace("**", "^")
            below = shown == "1" or shown.startswith("1/")
            groups.setdefault(times, []).append(symbol + shown[1:] if below else f"{symbol}*{shown}")
        parts = []
        for times, members in groups.items():
            word, joined = in_words(times), " + ".join(members)
            several = f"({joined})" if len(members) > 1 else joined
            parts.append(as_rate(f"{word}*{several}" if word else joined, times, list(groups)))
        left = left_side(list(groups)) if self.channel == TEMPERATURE else self.channel
        return f"{left} += {' + '.join(parts)}"

    def _shown(self, found: re.Match[str]) -> str:
        """A quantity as equations have it: ``aux/`` would read as a division."""
        return self.formula.over[int(found[1]) - 1].removeprefix(AUXILIARY)

    @property
    def variables(self) -> tuple[str, ...]:
        """Quantities it depends on, as tables name them."""
        back = {plain: name for name, plain in PLAIN.items()}
        names = [back.get(name, name) for name in self.formula.over]
        used = {p for times, _ in self.formula.parts for p in times.split("*")}
        return tuple(dict.fromkeys(names)) or tuple(FACTOR_OF[p] for p in used if p in FACTOR_OF)

    @property
    def times(self) -> tuple[str, ...]:
        """Factor of each of its parts."""
        return tuple(times for times, _ in self.formula.parts)

    @property
    def numbers(self) -> int:
        """Parameters by which it follows the data."""
        return len(self.formula.parts) + len(self.constants)

    @property
    def nodes(self) -> int:
        """Nodes of its tree, coefficients and sums counted."""
        return sum(formulas.nodes(text) + 2 for _, text in self.formula.parts) + len(self.formula.parts) - 1

    def columns(self, frame: Frame) -> FloatArray:
        """Regressors (n, parts) on the rows of a frame."""
        parts = self.formula.columns(frame)
        if self.channel != TEMPERATURE:
            return parts
        return of_temperature(parts, [times for times, _ in self.formula.parts], frame)

    def parameters(self, coefficients: FloatArray, std: FloatArray) -> list[dict[str, Any]]:
        """Symbol, value, unit and standard deviation of each coefficient and constant."""
        figures = zip(self.formula.coefficients, coefficients, self.units, std, strict=True)
        out: list[dict[str, Any]] = [
            {"symbol": s, "value": float(v), "unit": u, "std": float(d)} for s, v, u, d in figures
        ]
        return out + [{"symbol": c.symbol, "value": c.value, "unit": c.unit, "std": c.std} for c in self.constants]

    def row(self, coefficients: FloatArray, std: FloatArray) -> dict[str, Any]:
        """Its row of a simulation file, but for the effect."""
        parameters = {p.pop("symbol"): p for p in self.parameters(coefficients, std)}
        return self.formula.to_json() | {
            "channels": [self.channel],
            "equation": self.equation,
            "parameters": parameters,
            "units": {symbol: p["unit"] for symbol, p in parameters.items()},
        }

    def with_values(self, values: FloatArray, deviations: tuple[float | None, ...] = ()) -> Equation:
        """The same with other values of its constants."""
        stds: tuple[float | None, ...] = deviations or (None,) * len(self.constants)
        constants = tuple(
            replace(c, value=float(v), std=d) for c, v, d in zip(self.constants, values, stds, strict=True)
        )
        return replace(
            self,
            constants=constants,
            formula=replace(self.formula, constants=tuple((c.symbol, c.value) for c in constants)),
        )

    def without(self, part: int) -> Equation:
        """The same without one of its parts, and without constants and quantities that nothing needs then."""
        parts = tuple(p for k, p in enumerate(self.formula.parts) if k != part)
        units = tuple(u for k, u in enumerate(self.units) if k != part)
        text = " ".join(t for _, t in parts)
        kept = tuple(c for c in self.constants if re.search(rf"\b{c.symbol}\b", text))
        used = [i for i in range(len(self.formula.over)) if re.search(rf"\bx{i + 1}\b", text)]
        symbol = {f"x{i + 1}": f"x{k + 1}" for k, i in enumerate(used)}
        formula = Formula(
            tuple(self.formula.over[i] for i in used),
            tuple(self.formula.within[i] for i in used),
            tuple((times, re.sub(r"\bx\d+\b", lambda m: symbol[m[0]], expression)) for times, expression in parts),
            tuple((c.symbol, c.value) for c in kept),
        )
        return replace(self, formula=formula, units=units, constants=kept)


def from_row(row: Mapping[str, Any], channel: str, effect: str, where: str) -> tuple[Equation, FloatArray]:
    """A formula of a simulation file with its coefficients (parts,). Raises ConfigurationError, see
    :func:`bench.simulation.formulas.from_json`.
    """
    formula, coefficients = formulas.from_json(row, where)
    units = {str(s): str(u) for s, u in dict(row.get("units", {})).items()}
    constants = tuple(Constant(s, v, units.get(s, "1"), positive=s.startswith("s")) for s, v in formula.constants)
    return Equation(
        channel, formula, tuple(units.get(s, "1") for s in formula.coefficients), constants, effect
    ), coefficients
