"""What an identification becomes outside: the simulation file and the JSON summary."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from bench.identification.balances.heat import HEAT_UNITS
from bench.identification.balances.instant import systematic_entry
from bench.identification.balances.load_side import LOAD_UNITS
from bench.identification.balances.slow_equations import FRICTION_UNITS
from bench.identification.identify import Identification
from bench.identification.left import left_entry
from bench.identification.loads import loads_entry
from bench.identification.plausible import KEY, implausible
from bench.identification.sensitivity import doubling_changes
from bench.identification.statistics.freedom import freedom_entry
from bench.identification.statistics.regression import LinearFit
from bench.identification.validation import PAPER_TABLE, table
from bench.simulation import Parameter, Simulation, Term
from bench.simulation.polynomial import TERM_NAMES

SYMBOL_TERMS: dict[str, str] = {
    "f_c": "friction.coulomb",
    "f_v": "friction.viscous",
    "f_vT": "friction.viscous_temperature_linear",
    "f_l": "friction.load_dependent",
    "J": "motor.inertia",
    "tau_0": "motor.torque_offset",
    "C": "thermal.loss_heating",
    "R": "thermal.convection",
    "T_amb": "thermal.convection",
    "f_b": "load.bearing_friction",
    "J_L": "load.inertia",
    "z_0": "load.torque_offset",
}
"""Symbol of each identified parameter and the term of the nominal simulation it belongs to."""
LINEAR_UNITS = {"f_c": "N", "f_v": "N*s/m", "J": "kg", "tau_0": "N", "f_b": "N", "J_L": "kg", "z_0": "N", "f_l": "1"}


def parameters(found: Identification) -> dict[str, Parameter]:
    """Identified parameters of the slow equations by symbol, with units and standard deviations."""
    units = {**FRICTION_UNITS, **LOAD_UNITS, **HEAT_UNITS}
    if found.linear:
        units |= LINEAR_UNITS
    out: dict[str, Parameter] = {}
    fits: tuple[LinearFit | Any, ...] = (found.friction, found.load_side, found.heat)
    for fit in fits:
        for symbol, value in fit.values.items():
            std = fit.std.get(symbol)
            out[symbol] = Parameter(value, units[symbol], std if std is not None and math.isfinite(std) else None)
    return out


def doubtful(found: Identification) -> dict[str, str]:
    """Return a sentence by symbol for each identified value that cannot be (:mod:`.plausible`)."""
    known = parameters(found)
    return implausible({s: p.value for s, p in known.items()}, {s: p.std for s, p in known.items()})


def to_simulation(found: Identification, method: str = "refined") -> Simulation:
    """Make the simulation file's content; parameters that were not determined stay absent.

    A value that cannot be stands there as it was found, with the key ``implausible`` of its term beside it.
    """
    simulation = Simulation.nominal(found.gearbox)
    by_term: dict[str, dict[str, Parameter]] = {}
    for symbol, parameter in parameters(found).items():
        by_term.setdefault(SYMBOL_TERMS[symbol], {})[symbol] = parameter
    freedom = {**found.friction.freedom, **found.load_side.freedom}
    doubts = doubtful(found)
    for effect, values in by_term.items():
        known = {symbol: freedom[symbol] for symbol in values if symbol in freedom}
        marks = {symbol: doubts[symbol] for symbol in values if symbol in doubts}
        extra: dict[str, Any] = freedom_entry(known) | ({KEY: marks} if marks else {})
        extra |= systematic_entry({s: std for s, std in found.friction.systematic.items() if s in values})
        simulation = simulation.with_term(Term(effect, parameters=values, extra=extra))
    if method in found.models:
        simulation = simulation.with_transmission_error(found.models[method])
        series = simulation.terms["te.fourier"]
        rests = freedom_entry({name: float(result.freedom) for name, result in found.refined.items()})
        chosen = tuple(float(f) for f in found.orders)
        # the paper's method has no standard deviations, so nothing that they could rest on
        behind: dict[str, Any] = {
            **(rests if method == "refined" else {}),
            **left_entry(found.scores, method),
            **loads_entry(found.refined),
        }
        simulation = simulation.with_term(
            Term("te.fourier", orders=chosen, coefficients=series.coefficients, extra=behind)
        )
    return simulation


def has_numbers(simulation: Simulation) -> bool:
    """Whether a simulation file says anything: a parameter's value, or coefficients of the transmission error."""
    return any(term.parameters or term.coefficients is not None for term in simulation.terms.values())


def better_on_validation(found: Identification) -> bool | None:
    """Whether ``refined`` beats ``paper`` on the validation points (mean RMSE, both directions); None without any."""
    rows = [s for s in found.scores if s.kind == "validation"]
    if not rows:
        return None
    return sum(s.rmse["refined"] for s in rows) < sum(s.rmse["paper"] for s in rows)


def verdict(found: Identification) -> str:
    """One sentence on which method is better where it counts."""
    better = better_on_validation(found)
    if better is None:
        return "There is no validation recording: which method is better is not decided."
    rows = [s for s in found.scores if s.kind == "validation"]
    refined, paper, bound = (1e6 * sum(s.rmse[m] for s in rows) / len(rows) for m in ("refined", "paper", "bound"))
    word = "better" if better else "NOT better"
    return (
        f"On {len(rows)} validation recordings the refined method is {word} than the paper's: mean RMSE "
        f"{refined:.2f} against {paper:.2f} µrad; the bound, a series fitted to each alone, is {bound:.2f} µrad."
    )


def _tidy(value: Any) -> Any:
    """Make a value JSON can hold: NaN becomes null."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: _tidy(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_tidy(item) for item in value]
    return value


def sensitivities(found: Identification) -> dict[str, dict[str, Any]]:
    """Changes that double the error, by direction: median over the orders for each polynomial term."""
    import numpy as np

    out: dict[str, dict[str, Any]] = {}
    errors = table(found.scores).get("identification", {})
    for direction, result in found.refined.items():
        if direction not in errors:
            continue
        changes = doubling_changes(result.fourier, result.design, errors[direction]["refined"]["rmse"])
        out[direction] = {
            name: dict(zip(TERM_NAMES, np.atleast_2d(values).mean(axis=0).tolist(), strict=True))
            for name, values in changes.items()
        }
    return out


def to_json(found: Identification) -> dict[str, Any]:
    """Return the summary that ``--json`` prints (SI units; standard deviations where known)."""
    summary = {
        "format": "bench-identification",
        "format_version": "1.0",
        "folder": str(found.folder),
        "recordings": {
            "read": len(found.reductions),
            "identification": sum(1 for s in found.scores if s.kind != "validation"),
            "validation": sum(1 for s in found.scores if s.kind == "validation"),
        },
        "left_out": [{"recording": s.recording, "why": s.why} for s in found.skipped],
        "not_determined": list(found.sentences),
        "implausible": doubtful(found),
        "orders": list(found.orders),
        "notch_orders": list(found.notch_orders),
        "proposed_orders": [
            {"order": p.order, "amplitude": p.amplitude, "share": p.share, "part": p.part, "used": p.used}
            for p in found.proposals
        ],
        "parameters": {
            symbol: {"value": p.value, "unit": p.unit, "std": p.std, "term": SYMBOL_TERMS[symbol]}
            | {"freedom": {**found.friction.freedom, **found.load_side.freedom}.get(symbol)}
            | {"systematic_std": found.friction.systematic.get(symbol)}
            for symbol, p in parameters(found).items()
        },
        "residual_rmse": {"motor_torque": found.friction.rmse, "load_torque": found.load_side.rmse}
        | {"temperature": found.heat.rmse},
        "transmission_error": table(found.scores),
        "paper_table": {
            title: {d: {"rmse": v[0], "mae": v[1]} for d, v in rows.items()} for title, rows in PAPER_TABLE.items()
        },
        "refined_better_on_validation": better_on_validation(found),
        "verdict": verdict(found),
        "sensitivities": sensitivities(found),
    }
    tidy: dict[str, Any] = _tidy(summary)
    return tidy
