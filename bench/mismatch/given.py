"""What a simulation file says of the comparison: terms switched off, terms in force beyond the nominal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from bench.errors import ConfigurationError
from bench.mismatch.motor_ripple import Ripple
from bench.mismatch.periodic import NOTHING, Periodic, Pulse
from bench.simulation.laws import from_json as law_from_json
from bench.simulation.model import Simulation, Term
from bench.simulation.terms import LIBRARY, TRANSMISSION_ERROR, Form, Point
from bench.simulation.terms import Term as LibraryTerm
from bench.simulation.terms.nominal.transmission_error import PAPER_ORDERS

WITH_ORDERS = ("te.harmonic", "te.sideband", "sensor.motor_encoder")
"""terms that give the series further orders, each with polynomials of its own"""


@dataclass(frozen=True, slots=True)
class KnownTerm:
    """A term in force in a channel; without ``point``, form and nonlinear parameters are chosen on the recordings."""

    term: LibraryTerm
    form: Form | None = None
    point: Point | None = None


@dataclass(frozen=True, slots=True)
class Given:
    """The simulation that recordings are compared with; the nominal one, calibrated, where nothing is said."""

    switched_off: tuple[str, ...] = ()
    orders: tuple[float, ...] = tuple(float(f) for f in PAPER_ORDERS)
    known: Mapping[str, tuple[KnownTerm, ...]] = field(default_factory=dict)
    periodic: Periodic = NOTHING
    ripples: tuple[Ripple, ...] = ()

    @classmethod
    def of(cls, model: Simulation) -> Given:
        """Read a simulation. Raises ConfigurationError where a term's form or numbers are not the library's."""
        off = tuple(effect for effect, term in LIBRARY.items() if term.nominal and not model.enabled(effect))
        rows = [t for e, t in model.terms.items() if e in LIBRARY and not LIBRARY[e].nominal and t.enabled]
        orders = _orders(model, "te.fourier" in off)
        for row in rows:
            orders |= {f for item in instances(row) for f in _own_orders(row.effect, item)}
        known: dict[str, list[KnownTerm]] = {}
        pulses: list[Pulse] = []
        laws = []
        ripples: list[Ripple] = []
        for row in rows:
            for item in instances(row):
                if "law" in item:
                    laws.append(law_from_json(row.effect, item["law"]))
                elif row.effect == "te.local_defect":
                    p = numbers(row.effect, item, ("theta_p", "w_p", "p"))
                    pulses.append(Pulse(p[0], p[1], p[2]))
                elif row.effect == "motor.torque_ripple":
                    n, cosine, sine = numbers(row.effect, item, ("n", "a_rc", "a_rs"))
                    at = float(item["parameters"].get("tau_r", 0.0))
                    ripples.append(Ripple(round(n), complex(cosine, sine), 0.0, at))
                elif not _own_orders(row.effect, item):
                    for channel, term in _linear(row.effect, item):
                        known.setdefault(channel, []).append(term)
        return cls(
            off,
            tuple(sorted(orders)),
            {channel: tuple(terms) for channel, terms in known.items()},
            Periodic(tuple(pulses), tuple(laws)),
            tuple(ripples),
        )


def instances(row: Term) -> Iterator[dict[str, Any]]:
    """A term's rows: itself and those under ``also``, each with ``parameters`` by symbol (numbers)."""
    first = {key: value for key, value in row.extra.items() if key != "also"}
    if row.orders is not None:
        first["orders"] = list(row.orders)
    yield {**first, "parameters": {symbol: p.value for symbol, p in row.parameters.items()}}
    for item in row.extra.get("also", []):
        given = {s: p["value"] if isinstance(p, dict) else p for s, p in item.get("parameters", {}).items()}
        yield {**item, "parameters": given}


def numbers(effect: str, item: Mapping[str, Any], symbols: tuple[str, ...]) -> list[float]:
    """Values of the parameters ``symbols``. Raises ConfigurationError where one is missing."""
    missing = [s for s in symbols if s not in item["parameters"]]
    if missing:
        raise ConfigurationError(
            f"the simulation's term {effect} has no {', '.join(missing)}; it should have {', '.join(symbols)}"
        )
    return [float(item["parameters"][s]) for s in symbols]


def _orders(model: Simulation, off: bool) -> set[float]:
    series = model.terms.get("te.fourier")
    if off:
        return set()
    if series is not None and series.orders is not None:
        return {float(f) for f in series.orders}
    return {float(f) for f in PAPER_ORDERS}


def _own_orders(effect: str, item: Mapping[str, Any]) -> list[float]:
    if effect not in WITH_ORDERS:
        return []
    if "orders" in item:
        return [float(f) for f in item["orders"]]
    p = item["parameters"]
    if effect == "te.sideband" and {"f", "m"} <= set(p):
        return [p["f"] - p["m"], p["f"] + p["m"]]
    return [float(p["f"])] if "f" in p else []


def _linear(effect: str, item: Mapping[str, Any]) -> Iterator[tuple[str, KnownTerm]]:
    """A term that is a regressor: form by name or by its parameters' symbols, in the channels named, else in all."""
    term = LIBRARY[effect]
    parameters = item["parameters"]
    for channel in item.get("channels", list(term.forms)):
        forms = term.forms.get(channel, ())
        named = [f for f in forms if f.name == item["form"]] if "form" in item else list(forms)
        if not named:
            raise ConfigurationError(
                f"the simulation's term {effect} has the form {item.get('form')!r} in {channel}, it should be one of "
                f"{', '.join(f.name for f in forms) or 'those of a channel it shows in'}"
            )
        if "point" in item and "form" in item:
            point = tuple(float(v) for v in item["point"])
            if len(point) != len(named[0].nonlinear):
                raise ConfigurationError(
                    f"the simulation's term {effect} has {len(point)} numbers in 'point', it should have one for each "
                    f"of {', '.join(s.symbol for s in named[0].nonlinear) or 'nothing'}"
                )
            yield channel, KnownTerm(term, named[0], point)
            continue
        full = [f for f in named if all(s.symbol in parameters for s in f.nonlinear)]
        alike = [f for f in full if all(s.symbol in parameters for s in f.linear)] or full
        if alike and (parameters or not alike[0].nonlinear):
            yield channel, KnownTerm(term, alike[0], tuple(float(parameters[s.symbol]) for s in alike[0].nonlinear))
        elif channel == TRANSMISSION_ERROR and effect in ("te.resonance", *WITH_ORDERS):
            raise ConfigurationError(
                f"the simulation's term {effect} has neither orders nor a law; it should say which orders it touches"
            )
        else:
            yield channel, KnownTerm(term)
