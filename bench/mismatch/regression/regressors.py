"""What may stand in a model of a channel: terms of the library, and free functions.

Both give columns on any rows and a row of a simulation file; nothing else of the analysis asks which of the two it has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import FACTOR_OF, QUANTITIES, REMEMBERED, in_words, kind_of, label
from bench.simulation.reading import as_rate, is_read, left_side, of_temperature, unit_of_function
from bench.simulation.tables import Grid
from bench.simulation.terms import CHANNEL_UNITS, LIBRARY, TEMPERATURE, Form, Point, Term

UNKNOWN = "unknown"
STRAIGHT = 2
"""knots of a straight line"""


class Regressor(Protocol):
    """A term or a free function of one channel."""

    @property
    def effect(self) -> str:
        """Id of the vocabulary."""
        ...

    @property
    def words(self) -> str:
        """What it is, for people."""
        ...

    @property
    def equation(self) -> str:
        """Its equation."""
        ...

    @property
    def variables(self) -> tuple[str, ...]:
        """Quantities it depends on, the most telling first."""
        ...

    @property
    def numbers(self) -> int:
        """Parameters by which it follows the data."""
        ...

    def columns(self, frame: Frame) -> FloatArray:
        """Regressors (n, k) on the rows of a frame."""
        ...

    def parameters(self, coefficients: FloatArray, std: FloatArray) -> list[dict[str, Any]]:
        """Symbol, value, unit and standard deviation of each parameter, as reports have them."""
        ...

    def row(self, coefficients: FloatArray, std: FloatArray) -> dict[str, Any]:
        """Its row of a simulation file, but for the effect."""
        ...


@runtime_checkable
class OfFactors(Protocol):
    """A function times factors: tables or a formula."""

    @property
    def channel(self) -> str:
        """The channel it acts on."""
        ...

    @property
    def times(self) -> tuple[str, ...]:
        """Factor of each of its parts."""
        ...


@dataclass(frozen=True, slots=True)
class Named:
    """A term of the library in one form at one point of its nonlinear parameters.

    ``deviation``: standard deviations of the point, once it is refined; None where the recordings do not tell one.
    ``carried``: standard deviations of the coefficients that these alone give them; none before.
    """

    term: Term
    channel: str
    form: Form
    point: Point = ()
    deviation: tuple[float | None, ...] = ()
    carried: tuple[float, ...] = ()

    @property
    def effect(self) -> str:
        """Id of the vocabulary."""
        return self.term.effect

    @property
    def words(self) -> str:
        """What it is, for people."""
        return self.term.name

    @property
    def equation(self) -> str:
        """Its equation."""
        return self.term.equation_of(self.form)

    @property
    def variables(self) -> tuple[str, ...]:
        """Quantities it depends on, the most telling first."""
        return self.term.variables_of(self.form)

    @property
    def numbers(self) -> int:
        """Parameters by which it follows the data."""
        return len(self.form.linear) + len(self.point)

    def columns(self, frame: Frame) -> FloatArray:
        """Regressors (n, k) on the rows of a frame."""
        return self.form.columns(frame, self.point)

    def parameters(self, coefficients: FloatArray, std: FloatArray) -> list[dict[str, Any]]:
        """Symbol, value, unit and standard deviation of each parameter, as reports have them: of a coefficient with
        what it owes to how sure the point is.
        """
        carried = self.carried or (0.0,) * len(self.form.linear)
        out = [
            {"symbol": s.symbol, "value": float(v), "unit": s.unit, "std": float(np.hypot(d, more))}
            for s, v, d, more in zip(self.form.linear, coefficients, std, carried, strict=True)
        ]
        deviation: Sequence[float | None] = self.deviation or [None] * len(self.point)
        for s, v, spread in zip(self.form.nonlinear, self.point, deviation, strict=True):
            out.append({"symbol": s.symbol, "value": float(v), "unit": s.unit, "std": spread})
        return out

    def row(self, coefficients: FloatArray, std: FloatArray) -> dict[str, Any]:
        """Its row of a simulation file, but for the effect."""
        parameters = {p.pop("symbol"): p for p in self.parameters(coefficients, std)}
        return {"form": self.form.name, "point": list(self.point), "channels": [self.channel], "parameters": parameters}


@dataclass(frozen=True, slots=True)
class Free:
    """A free function: tables over one or more quantities, each times a factor; summed.

    In the heat balance it is a rate of the temperature, integrated over each recording, or what the thermometer reads
    beyond it (:mod:`bench.simulation.reading`). ``mixing`` (values of the tables, numbers): how its numbers make the
    values, where these are not numbers of their own.
    """

    channel: str
    grids: tuple[Grid, ...]
    effect: str = UNKNOWN
    mixing: tuple[tuple[float, ...], ...] = ()

    @property
    def words(self) -> str:
        """What it is, for people."""
        if not self.grids[0].over:
            return "a product: " + " and ".join(in_words(g.times) for g in self.grids)
        if self.grids[0].course:
            return self.grids[0].course
        of = " and ".join(label(name) for name in self.grids[0].over)
        times = {in_words(g.times) for g in self.grids} - {""}
        straight = all(len(knots) == STRAIGHT for g in self.grids for knots in g.knots)
        read = ", read by the thermometer" if of_reading(self) else ""
        return f"a {'straight line over' if straight else 'function of'} {of}{read}" + (
            f", times {' and '.join(sorted(times))}" if times else ""
        )

    @property
    def equation(self) -> str:
        """Its equation."""
        parts = []
        for number, grid in enumerate(self.grids):
            mark = self._mark(number)
            name = f"f{mark}"
            times = in_words(grid.times)
            if not grid.over:
                parts.append(f"c{mark}*{times}")
                continue
            function = grid.formula or f"{name}({', '.join(grid.over)})"
            parts.append(as_rate(f"{times + '*' if times else ''}{function}", grid.times, self.times))
        left = left_side(self.times) if self.channel == TEMPERATURE else self.channel
        return f"{left} += {' + '.join(parts)}" + (", f a table" if self.variables_of_tables else "")

    @property
    def variables(self) -> tuple[str, ...]:
        """Quantities it depends on, the most telling first."""
        names = [name for g in self.grids for name in g.over]
        names += [FACTOR_OF[part] for g in self.grids if not g.over for part in g.times.split("*") if part in FACTOR_OF]
        return tuple(dict.fromkeys(names))

    @property
    def times(self) -> tuple[str, ...]:
        """Factor of each of its tables."""
        return tuple(g.times for g in self.grids)

    def _mark(self, number: int) -> str:
        """What tells the symbols of one of several grids from the others'."""
        return "" if len(self.grids) == 1 else f"_{number + 1}"

    @property
    def variables_of_tables(self) -> bool:
        """Whether some part is a table."""
        return any(g.over and not g.formula for g in self.grids)

    @property
    def numbers(self) -> int:
        """Parameters by which it follows the data."""
        return len(self.mixing[0]) if self.mixing else sum(g.size for g in self.grids)

    def values(self, coefficients: FloatArray) -> FloatArray:
        """Values of the tables at their knots."""
        return np.asarray(self.mixing) @ coefficients if self.mixing else coefficients

    def columns(self, frame: Frame) -> FloatArray:
        """Regressors (n, k) on the rows of a frame."""
        parts = np.hstack([g.columns(frame) for g in self.grids])
        if self.channel == TEMPERATURE:
            parts = of_temperature(parts, [grid.times for grid in self.grids for _ in range(grid.size)], frame)
        return parts @ np.asarray(self.mixing) if self.mixing else parts

    def parameters(self, coefficients: FloatArray, std: FloatArray) -> list[dict[str, Any]]:
        """Value of the function at each knot."""
        if self.mixing:
            coefficients, std = self.values(coefficients), np.sqrt(np.asarray(self.mixing) ** 2 @ std**2)
        out = []
        at = 0
        for number, grid in enumerate(self.grids):
            times = in_words(grid.times) if grid.over else ""
            mark = "" if grid.formula else self._mark(number)
            unit = unit_of_function(grid.times) if self.channel == TEMPERATURE else CHANNEL_UNITS[self.channel]
            for symbol in (s[0] + mark + s[1:] for s in grid.symbols):
                out.append(
                    {
                        "symbol": symbol + (f"*{times}" if times else ""),
                        "value": float(coefficients[at]),
                        "unit": unit,
                        "std": float(std[at]),
                    }
                )
                at += 1
        return out

    def rows(self, coefficients: FloatArray) -> list[dict[str, Any]]:
        """Its rows of a simulation file, but for the effect: a table each."""
        coefficients = self.values(coefficients)
        out = []
        at = 0
        for grid in self.grids:
            out.append(grid.to_json(coefficients[at : at + grid.size]) | {"channels": [self.channel]})
            at += grid.size
        return out

    def row(self, coefficients: FloatArray, std: FloatArray) -> dict[str, Any]:
        """The first of its rows."""
        del std
        return self.rows(coefficients)[0]


def kinds(regressor: Regressor) -> tuple[str, ...]:
    """Quantities a regressor depends on; of states that are not recorded their kinds: with another scale it is the same
    function.
    """
    return tuple(dict.fromkeys(map(kind_of, regressor.variables)))


def knots_of_table(regressor: Regressor) -> tuple[float, ...]:
    """Knots of a function of one quantity that is a plain table; none of anything else."""
    if not isinstance(regressor, Free) or regressor.mixing:
        return ()
    first = regressor.grids[0]
    plain = all(type(g) is Grid and (g.over, g.knots) == (first.over, first.knots) for g in regressor.grids)
    return first.knots[0] if plain and len(first.over) == 1 else ()


def of_reading(regressor: Regressor) -> bool:
    """Whether a regressor is what a thermometer reads beyond the temperature, and warms nothing."""
    return isinstance(regressor, OfFactors) and regressor.channel == TEMPERATURE and all(map(is_read, regressor.times))


def named(effect: str, channel: str, form: str, point: Point = ()) -> Named:
    """A term of the library by its names. Raises StopIteration where there is no such form."""
    term = LIBRARY[effect]
    return Named(term, channel, next(f for f in term.forms[channel] if f.name == form), point)


def remembers(regressor: Regressor) -> bool:
    """Whether a regressor has a state that goes on from one recording to the next."""
    if isinstance(regressor, Named) and regressor.form.remembers:
        return True
    return not REMEMBERED.isdisjoint(kind_of(name) for name in regressor.variables)


def unit_of(name: str) -> str:
    """Unit of a quantity, empty for an auxiliary one."""
    return QUANTITIES[name].unit if name in QUANTITIES else ""


def by_definition(channel: str, name: str, factors: tuple[str, ...]) -> str:
    """The effect that any function of a quantity ``name``, times these factors, is, where one is defined so."""
    wanted = {(kind_of(name), times) for times in factors}
    for term in LIBRARY.values():
        shapes = set(term.shape.get(channel, ()))
        # a function that is the same in both directions is one in each
        alike = {(of, "1") for of, _ in shapes if {(of, "p"), (of, "n")} <= shapes}
        if term.any_function and wanted <= shapes | alike:
            return term.effect
    return UNKNOWN
