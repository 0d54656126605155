"""The improved simulation: calibrated nominal terms and every named finding, as a simulation file."""

from __future__ import annotations

from typing import Any

import numpy as np

from bench.mismatch.channels import Analysis
from bench.mismatch.findings import Finding
from bench.mismatch.laws import Law
from bench.mismatch.linear import ChannelModel
from bench.mismatch.motor_ripple import Ripple
from bench.mismatch.peaks import Peak
from bench.simulation.model import Parameter, Simulation, Term
from bench.simulation.terms import LIBRARY


def improved(findings: list[Finding], analysis: Analysis | None, start: Simulation) -> Simulation:
    """Return ``start`` with calibrated nominal parameters and the terms of the findings (unknown ones have none)."""
    out = start
    if analysis is not None:
        for model in analysis.models.values():
            out = _calibrated(out, model)
    for finding in findings:
        if finding.effect == "unknown" or finding.effect not in LIBRARY:
            continue
        out = out.with_term(_term(finding))
    return out


def _calibrated(out: Simulation, model: ChannelModel) -> Simulation:
    chosen = [*model.chosen, *model.correction]
    place = {column: k for k, column in enumerate(model.index(chosen))}
    for effect, form_name, index in model.layout.base_effects:
        term = LIBRARY.get(effect)
        if term is None or not term.nominal or effect == "te.offset":
            continue
        form = next(f for f in term.forms[model.channel] if f.name == form_name)
        own = [place[i] for i in index]
        std = np.sqrt(np.maximum(np.diag(model.fit.covariance)[own], 0.0))
        values = {
            s.symbol: Parameter(float(v), s.unit, float(d))
            for s, v, d in zip(form.linear, model.fit.coefficients[own], std, strict=True)
        }
        out = out.with_term(Term(effect, True, values))
    return out


def _term(finding: Finding) -> Term:
    values = {p["symbol"]: Parameter(float(p["value"]), str(p["unit"]), float(p["std"])) for p in finding.parameters}
    extra: dict[str, Any] = {}
    if isinstance(finding.source, Law):
        extra = {"law": {"form": finding.source.form, "point": list(finding.source.point)}}
    elif isinstance(finding.source, list) and finding.source and isinstance(finding.source[0], Ripple):
        extra = {"motor_orders": [r.order for r in finding.source]}
    elif isinstance(finding.source, list) and finding.source and isinstance(finding.source[0], Peak):
        peaks: list[Peak] = finding.source
        if finding.effect == "te.local_defect":
            pulses = [{"form": "gaussian", "point": [p.angle, p.width]} for p in peaks]
            extra = {**pulses[0], "also": pulses[1:]}
        else:
            extra = {"orders": [float(f) for p in peaks for f in p.orders]}
    else:
        extra = {"form": finding.form, "point": list(finding.point), "channels": [finding.channel]}
    if LIBRARY[finding.effect].nominal:
        return Term(finding.effect, True)
    return Term(finding.effect, True, values, None, None, extra)
