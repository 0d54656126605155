"""The improved simulation: calibrated nominal terms and every named finding, as a simulation file.

What stands in it is in force in a further comparison and on the emulator. A finding that shows in several channels, or
at several orders, has one row in the file; its further parts stand under ``also``, each with form and parameters.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bench.mismatch.channels import Analysis
from bench.mismatch.columns import RIPPLE_ORDERS
from bench.mismatch.findings import Finding
from bench.mismatch.findings import parameters as found_parameters
from bench.mismatch.judge import Found
from bench.mismatch.linear import ChannelModel
from bench.mismatch.motor_ripple import Ripple
from bench.mismatch.peaks import Peak
from bench.mismatch.series import Scaling, Series
from bench.mismatch.transmission import TransmissionModel
from bench.simulation.fourier import FourierSet, TransmissionErrorModel
from bench.simulation.frame import FloatArray
from bench.simulation.laws import Law
from bench.simulation.model import Parameter, Simulation, Term
from bench.simulation.polynomial import Standardisation
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE, TRANSMISSION_ERROR
from bench.simulation.terms.nominal.transmission_error import CENTRE, SPREAD

Row = dict[str, Any]


def improved(findings: list[Finding], analysis: Analysis | None, start: Simulation) -> Simulation:
    """Return ``start`` with calibrated nominal parameters and the terms of the findings (unknown ones have none)."""
    out = start
    for finding in findings:
        if finding.effect not in LIBRARY:
            continue
        if LIBRARY[finding.effect].nominal:
            out = out.with_term(Term(finding.effect, True, _parameters(_rows(finding))))
            continue
        rows = [row for part in (finding, *finding.more) for row in _rows(part)]
        out = out.with_term(_term(finding.effect, rows, out.terms.get(finding.effect)))
    if analysis is None:
        return out
    for model in analysis.models.values():
        out = _calibrated(out, model)
    if analysis.transmission is not None:
        out = _with_series(out, analysis.transmission)
    return out


def _term(effect: str, rows: list[Row], before: Term | None) -> Term:
    """A term of its rows; those that the simulation had already stay in force beside them."""
    if before is not None and before.enabled and (before.parameters or before.extra):
        given = {s: {"value": p.value, "unit": p.unit, "std": p.std} for s, p in before.parameters.items()}
        first = {key: value for key, value in before.extra.items() if key != "also"}
        if before.orders is not None:
            first["orders"] = list(before.orders)
        rows = [{**first, "parameters": given}, *before.extra.get("also", []), *rows]
    extra = {key: value for key, value in rows[0].items() if key != "parameters"}
    if len(rows) > 1:
        extra["also"] = rows[1:]
    return Term(effect, True, _parameters(rows), None, None, extra)


def _parameters(rows: list[Row]) -> dict[str, Parameter]:
    given = rows[0].get("parameters", {}) if rows else {}
    return {s: Parameter(float(p["value"]), str(p["unit"]), p["std"]) for s, p in given.items()}


def _rows(finding: Finding) -> list[Row]:
    """What a finding adds to the simulation, a row for each regressor, order, pulse or law."""
    source = finding.source
    if isinstance(source, Found):
        told = found_parameters(finding.channel, source)
        place = {"form": source.entry.form, "point": list(source.entry.point), "channels": [finding.channel]}
        return [{**place, "parameters": _by_symbol(told)}]
    if isinstance(source, Law):
        return [{"law": source.to_json()}]
    if isinstance(source, list):
        return [row for part in source for row in (_ripple(part) if isinstance(part, Ripple) else _peak(part))]
    return []


def _by_symbol(parameters: list[dict[str, Any]]) -> dict[str, Any]:
    return {str(p["symbol"]): {"value": p["value"], "unit": p["unit"], "std": p["std"]} for p in parameters}


def _row(channel: str, form: str, values: dict[str, tuple[float, str, float]]) -> Row:
    told = {s: {"value": v, "unit": unit, "std": std} for s, (v, unit, std) in values.items()}
    return {"form": form, "channels": [channel], "parameters": told}


def _ripple(ripple: Ripple) -> list[Row]:
    std = float(abs(ripple.amplitude) / np.sqrt(max(2.0 * ripple.gain, 1.0)))
    values = {
        "a_rc": (ripple.amplitude.real, "N*m", std),
        "a_rs": (ripple.amplitude.imag, "N*m", std),
        "n": (float(ripple.order), "1", 0.0),
    }
    if ripple.at:
        values["tau_r"] = (ripple.at, "N*m", 0.0)
    return [_row(MOTOR_TORQUE, "ripple", values)]


def _peak(peak: Peak) -> list[Row]:
    """A pulse; a new order; or a pair of sidebands. The last two also stand among the orders of ``te.fourier``."""
    if peak.kind == "pulse":
        values = {
            "p": (peak.height, "rad", 0.05 * abs(peak.height)),
            "theta_p": (peak.angle, "rad", 0.1 * peak.width),
            "w_p": (peak.width, "rad", 0.3 * peak.width),
        }
        return [_row(TRANSMISSION_ERROR, "gaussian", values)]
    return [{"orders": [float(f) for f in peak.orders]}]


def _calibrated(out: Simulation, model: ChannelModel) -> Simulation:
    chosen = [*model.chosen, *model.correction]
    place = {column: k for k, column in enumerate(model.index(chosen))}
    for effect, form_name, index in model.layout.base_effects:
        term = LIBRARY.get(effect)
        if term is None or not term.nominal or effect == "te.offset":
            continue
        form = next(f for f in term.forms[model.channel] if f.name == form_name)
        own = [place[i] for i in index]
        if not np.any(model.layout.columns[:, list(index)]):
            continue  # nothing in these recordings depends on it: it stays as it was
        std = np.sqrt(np.maximum(np.diag(model.fit.covariance)[own], 0.0))
        values = {
            s.symbol: Parameter(float(v), s.unit, float(d))
            for s, v, d in zip(form.linear, model.fit.coefficients[own], std, strict=True)
        }
        out = out.with_term(Term(effect, True, values))
    return out


def _with_series(out: Simulation, model: TransmissionModel) -> Simulation:
    """Return ``out`` with the calibrated series and offset in the paper's coefficients."""
    offset = _offset(model.offset)
    series = model.harmonics.series if model.harmonics is not None else None
    sets = [_side(series, side, offset[k], model) for k, side in enumerate((1, -1))]
    if all(part is None for part in sets):
        return out
    coefficients = TransmissionErrorModel(sets[0], sets[1])
    before = out.terms.get("te.fourier", Term("te.fourier"))
    orders = before.orders
    if out.enabled("te.fourier"):
        out = out.with_term(Term("te.fourier", True, {}, orders, coefficients, before.extra))
    if out.enabled("te.offset"):
        out = out.with_term(Term("te.offset", True, {}, None, coefficients))
    return out


def _offset(model: ChannelModel) -> FloatArray:
    """The offset's coefficients (2, 10) for τ in N·m, θ̇ in rad/s, T in °C; 0 where it is switched off."""
    place = {column: k for k, column in enumerate(model.index([*model.chosen, *model.correction]))}
    found = [index for effect, _, index in model.layout.base_effects if effect == "te.offset"]
    if not found:
        return np.zeros((2, 10))
    scaled = model.fit.coefficients[[place[i] for i in found[0]]].reshape(2, 10)
    return Standardisation(np.asarray(CENTRE), np.asarray(SPREAD)).to_raw(scaled)


def _side(series: Series | None, side: int, offset: FloatArray, model: TransmissionModel) -> FourierSet | None:
    if series is None or side not in series.amplitude:
        return None
    raw = _standardisation(series.scaling[side])
    own = [k for k, f in enumerate(series.orders) if f not in RIPPLE_ORDERS]
    orders = np.asarray(series.orders)[own]
    by_order = np.argsort(orders)
    amplitude, phase = (raw.to_raw(table[side][own])[by_order] for table in (series.amplitude, series.phase))
    return FourierSet(orders[by_order], amplitude, phase, offset)


def _standardisation(scaling: Scaling) -> Standardisation:
    return Standardisation(scaling.centre, scaling.spread)
