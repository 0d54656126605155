"""The simulation file ``model.json``: which terms are in force, with which parameters.

Read and written by identification, mismatch analysis and emulator. A term that is not listed is as in the nominal
simulation; one that is enabled without parameters is calibrated on recordings. Keys this module does not know are kept.
"""

from __future__ import annotations

import difflib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from bench.errors import ConfigurationError
from bench.simulation._coefficients import fourier_from_json, fourier_to_json
from bench.simulation.fourier import FourierSet, TransmissionErrorModel
from bench.whole import write_whole

FORMAT = "bench-simulation"
FORMAT_VERSION = "1.0"

NOMINAL_TERMS: tuple[str, ...] = (
    "te.fourier",
    "te.offset",
    "friction.coulomb",
    "friction.viscous",
    "friction.viscous_temperature_linear",
    "friction.load_dependent",
    "motor.load_reaction",
    "motor.inertia",
    "motor.torque_offset",
    "thermal.loss_heating",
    "thermal.convection",
    "load.reaction",
    "load.bearing_friction",
    "load.inertia",
    "load.torque_offset",
)
"""Ids of the nominal simulation's terms (bench-physics, "Nominal simulation")."""

_COEFFICIENT_TERMS = ("te.fourier", "te.offset")


TEETH = ("z1", "z2", "z3", "z4")
"""tooth numbers of a gearbox"""
SAME_RATIO = 1e-3
"""relative difference up to which two gear ratios are one, rounded: tooth numbers make far larger steps"""


@dataclass(frozen=True, slots=True)
class Gearbox:
    """Ratio u and tooth numbers, None where the gearbox has none."""

    ratio: float = 185.0
    z1: int | None = 24
    z2: int | None = 96
    z3: int | None = 45
    z4: int | None = 46

    def unlike(self, ratio: float) -> str:
        """A sentence where recordings are of another ``ratio``; empty where they are not."""
        if abs(ratio - self.ratio) <= SAME_RATIO * abs(self.ratio):
            return ""
        return (
            f"the simulation is of a gearbox of ratio {self.ratio:g}, the recordings are of one of ratio {ratio:g}: "
            "its torques and orders are those of another gearbox"
        )


@dataclass(frozen=True, slots=True)
class Parameter:
    """A value in its SI ``unit``, with its standard deviation where known."""

    value: float
    unit: str = "1"
    std: float | None = None


@dataclass(frozen=True, slots=True)
class Term:
    """One term of the simulation.

    ``parameters`` by symbol (empty: to be calibrated); ``orders`` restricts ``te.fourier`` (None: all);
    ``coefficients`` holds those of ``te.fourier`` and ``te.offset``; ``extra`` keeps all other keys as they stood in
    the file.
    """

    effect: str
    enabled: bool = True
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    orders: tuple[float, ...] | None = None
    coefficients: TransmissionErrorModel | None = None
    extra: Mapping[str, Any] = field(default_factory=dict)

    def rows(self) -> Iterator[dict[str, Any]]:
        """Its rows: itself and those under ``also``, each with ``parameters`` by symbol (numbers)."""
        first = {key: value for key, value in self.extra.items() if key != "also"}
        if self.orders is not None:
            first["orders"] = list(self.orders)
        if first or self.parameters or "also" not in self.extra:
            yield {**first, "parameters": {symbol: p.value for symbol, p in self.parameters.items()}}
        for row in self.extra.get("also", []):
            values = {s: p["value"] if isinstance(p, dict) else p for s, p in row.get("parameters", {}).items()}
            yield {**row, "parameters": values}


@dataclass(frozen=True, slots=True)
class Simulation:
    """A simulation file: gearbox, terms by id, and whatever else stood in it (``extra``)."""

    gearbox: Gearbox = Gearbox()
    terms: Mapping[str, Term] = field(default_factory=dict)
    extra: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def nominal(cls, gearbox: Gearbox | None = None) -> Simulation:
        """Return the nominal simulation: its terms all in force, none with parameters yet."""
        return cls(gearbox or Gearbox(), {name: Term(name) for name in NOMINAL_TERMS})

    @classmethod
    def load(cls, path: str | Path) -> Simulation:
        """Read a ``model.json``. Raises ConfigurationError with the place of what is wrong."""
        path = Path(path)
        try:
            data = json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError as error:
            raise ConfigurationError(f"{path}: there is no such file.") from error
        except (OSError, ValueError) as error:
            raise ConfigurationError(f"{path}: not readable as JSON ({error}).") from error
        return cls.from_json(data, str(path))

    @classmethod
    def from_json(cls, data: Any, where: str = "model") -> Simulation:
        """Build a simulation from the parsed file; ``where`` names it in errors."""
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            raise ConfigurationError(f"{where}: 'format' should be '{FORMAT}', this is not a simulation file.")
        if str(data.get("format_version", "")).split(".")[0] != "1":
            raise ConfigurationError(
                f"{where}: format_version {data.get('format_version')!r} is not known, it should be '{FORMAT_VERSION}'."
            )
        terms: dict[str, Term] = {name: Term(name) for name in NOMINAL_TERMS}
        rows = data.get("terms", [])
        if not isinstance(rows, list):
            raise ConfigurationError(f"{where}: 'terms' should be a list of objects.")
        for number, row in enumerate(rows):
            term = _term(row, f"{where}: terms[{number}]")
            terms[term.effect] = term
        series = terms["te.fourier"].coefficients
        if terms["te.offset"].coefficients is None and series is not None:
            # a₀ may stand beside the orders in ``te.fourier``; it belongs to ``te.offset``.
            terms["te.offset"] = replace(terms["te.offset"], coefficients=series)
        known = {"format", "format_version", "gearbox", "terms"}
        return cls(
            _gearbox(data.get("gearbox", {}), f"{where}: gearbox"),
            terms,
            {key: value for key, value in data.items() if key not in known},
        )

    def to_json(self) -> dict[str, Any]:
        """Return the file's content; terms in the nominal order first, then the others as they were added."""
        names = [n for n in NOMINAL_TERMS if n in self.terms] + [n for n in self.terms if n not in NOMINAL_TERMS]
        gearbox = {k: getattr(self.gearbox, k) for k in ("ratio", *TEETH)}
        return {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "gearbox": {key: value for key, value in gearbox.items() if value is not None},
            "terms": [_term_to_json(self.terms[name]) for name in names],
            **self.extra,
        }

    def save(self, path: str | Path) -> None:
        """Write the simulation file."""
        write_whole(Path(path), json.dumps(self.to_json(), indent=1, allow_nan=False) + "\n")

    def enabled(self, effect: str) -> bool:
        """Whether a term is in force; a nominal term that is not listed is, any other is not."""
        term = self.terms.get(effect)
        return effect in NOMINAL_TERMS if term is None else term.enabled

    def value(self, effect: str, symbol: str) -> float | None:
        """Value of a parameter; 0 for a term that is switched off, None where it was not calibrated."""
        if not self.enabled(effect):
            return 0.0
        term = self.terms.get(effect)
        parameter = term.parameters.get(symbol) if term else None
        return None if parameter is None else parameter.value

    def with_term(self, term: Term) -> Simulation:
        """Return a copy in which ``term`` replaces the term of its id."""
        return replace(self, terms={**self.terms, term.effect: term})

    def with_transmission_error(self, model: TransmissionErrorModel) -> Simulation:
        """Return a copy with the coefficients of ``te.fourier`` and ``te.offset`` replaced; on/off and orders stay."""
        terms = dict(self.terms)
        for name in _COEFFICIENT_TERMS:
            terms[name] = replace(terms.get(name, Term(name)), coefficients=model)
        return replace(self, terms=terms)

    def transmission_error(self) -> TransmissionErrorModel | None:
        """Return the transmission error in force, without what is switched off; None where it was not calibrated."""
        fourier, offset = self.terms.get("te.fourier"), self.terms.get("te.offset")
        series = fourier.coefficients if fourier else None
        constant = offset.coefficients if offset else None
        if series is None and constant is None:
            return None
        sets: list[FourierSet | None] = []
        for sign in (1.0, -1.0):
            wave = series.direction(sign) if series else None
            level = constant.direction(sign) if constant else wave
            if wave is None and level is None:
                sets.append(None)
                continue
            base = wave if wave is not None else FourierSet.zeros(())
            if not self.enabled("te.fourier"):
                base = base.select(())
            elif fourier is not None and fourier.orders is not None:
                base = base.select(fourier.orders)
            if not self.enabled("te.offset"):
                base = replace(base, offset=0.0 * base.offset, offset_std=None, offset_covariance=None)
            elif level is not None:
                base = replace(
                    base,
                    offset=level.offset,
                    offset_std=level.offset_std,
                    offset_covariance=level.offset_covariance,
                )
            sets.append(base)
        return TransmissionErrorModel(sets[0], sets[1])


def _gearbox(data: Any, where: str) -> Gearbox:
    if not isinstance(data, dict):
        raise ConfigurationError(f"{where} should be an object with 'ratio'.")
    ratio = data.get("ratio", 185.0)
    if not isinstance(ratio, int | float) or not math.isfinite(ratio) or ratio <= 0:
        raise ConfigurationError(f"{where}.ratio is {ratio!r}, it should be a positive number.")
    teeth = [data.get(key) for key in TEETH]
    for key, number in zip(TEETH, teeth, strict=True):
        if number is not None and (isinstance(number, bool) or not isinstance(number, int) or number < 1):
            raise ConfigurationError(f"{where}.{key} is {number!r}, it should be a number of teeth, or null.")
    return Gearbox(float(ratio), *teeth)


_SLIP = 0.9
"""likeness of two words (twice the letters that match over those of both) from which one is the other misspelt"""


def _parameter(data: Any, where: str) -> Parameter:
    if isinstance(data, int | float) and not isinstance(data, bool):
        return Parameter(float(data))
    if not isinstance(data, dict) or not isinstance(data.get("value"), int | float):
        raise ConfigurationError(f"{where} should be a number or an object with 'value', 'unit' and 'std'.")
    std = data.get("std")
    return Parameter(float(data["value"]), str(data.get("unit", "1")), None if std is None else float(std))


def _term(row: Any, where: str) -> Term:
    if not isinstance(row, dict) or not isinstance(row.get("effect"), str):
        raise ConfigurationError(f"{where} should be an object with 'effect', the id of a term.")
    effect, enabled = row["effect"], row.get("enabled", True)
    if not isinstance(enabled, bool):
        raise ConfigurationError(f"{where}.enabled is {enabled!r}, it should be true or false.")
    raw = row.get("parameters") or {}
    if not isinstance(raw, dict):
        raise ConfigurationError(f"{where}.parameters should be an object.")
    orders = row.get("orders")
    if orders is not None and not (isinstance(orders, list) and all(isinstance(f, int | float) for f in orders)):
        raise ConfigurationError(f"{where}.orders should be a list of numbers.")
    known = {"effect", "enabled", "parameters", "orders"}
    for key in sorted(row.keys() - known):
        # keys of later versions are kept; a slip of the pen would be taken for one, and what it says for nothing
        meant = difflib.get_close_matches(key.lower(), known - row.keys(), 1, _SLIP)
        if meant:
            raise ConfigurationError(f"{where} has the key '{key}', it should be '{meant[0]}'.")
    coefficients = None
    parameters: dict[str, Parameter] = {}
    if effect in _COEFFICIENT_TERMS:
        known |= {"std", "covariance"}
        if raw:
            coefficients = fourier_from_json(raw, row.get("std"), row.get("covariance"), where)
    else:
        parameters = {key: _parameter(value, f"{where}.parameters.{key}") for key, value in raw.items()}
    return Term(
        effect,
        enabled,
        parameters,
        None if orders is None else tuple(float(f) for f in orders),
        coefficients,
        {key: value for key, value in row.items() if key not in known},
    )


def _number(value: float) -> float | int:
    return int(value) if float(value).is_integer() else float(value)


def _term_to_json(term: Term) -> dict[str, Any]:
    row: dict[str, Any] = {"effect": term.effect, "enabled": term.enabled}
    if term.orders is not None:
        row["orders"] = [_number(f) for f in term.orders]
    if term.coefficients is not None:
        row |= fourier_to_json(term.coefficients, series=term.effect == "te.fourier")
    elif term.parameters:
        row["parameters"] = {
            symbol: {"value": p.value, "unit": p.unit} | ({} if p.std is None else {"std": p.std})
            for symbol, p in term.parameters.items()
        }
    return row | dict(term.extra)
