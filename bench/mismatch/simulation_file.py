"""The improved simulation: calibrated terms and a row of everything that was found, as a simulation file.

What stands in it is all that a prediction has (:mod:`bench.mismatch.prediction`), so a residual given as "after" can be
made again from the file alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bench.mismatch.analysis import Analysis
from bench.mismatch.discovery import Discovery
from bench.mismatch.given import REACTION
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.reaction import Reaction
from bench.mismatch.orders.series import Scaling, Series
from bench.mismatch.power_zeros import EFFECT, KEY
from bench.mismatch.regression.bank import Fit
from bench.mismatch.regression.discoveries import rows_of
from bench.mismatch.regression.model import Block, ChannelModel, Chosen
from bench.mismatch.regression.problem import NUISANCE
from bench.mismatch.regression.regressors import Free, Named
from bench.mismatch.regression.sensitivity import PARAMETER
from bench.simulation.fourier import FourierSet, TransmissionErrorModel
from bench.simulation.frame import FloatArray
from bench.simulation.model import TEETH, Gearbox, Parameter, Simulation, Term
from bench.simulation.polynomial import Standardisation
from bench.simulation.quantities import INPUT_ANGLE
from bench.simulation.terms import LIBRARY, TEMPERATURE
from bench.simulation.terms.nominal.transmission_error import CENTRE, SPREAD

Row = Mapping[str, Any]


def improved(analysis: Analysis, gearbox: object) -> Simulation:
    """The given simulation, calibrated, with every discovery."""
    found = [d for outcome in analysis.outcomes.values() for d in outcome.discoveries]
    return _completed(analysis, found, gearbox)


def recalibrated(analysis: Analysis, gearbox: object) -> Simulation:
    """The given simulation, calibrated, with nothing added."""
    return _completed(analysis, None, gearbox)


def _completed(analysis: Analysis, found: Sequence[Discovery] | None, gearbox: object) -> Simulation:
    out = of_gearbox(analysis.given.simulation, gearbox)
    rows: list[Row] = []
    models = {channel: search.model for channel, search in analysis.searches.items()}
    whole = analysis.transmission
    if whole is not None and whole.offset is not None:
        models[whole.offset.model.channel] = whole.offset.model
    known = set()
    for model in models.values():
        fit = model.fit if found is not None else analysis.plain.get(model.channel) or model.refitted([])
        whose = {id(k.regressor): k.whose for k in analysis.given.known.get(model.channel, ())}
        for block in model.base:
            effect = block.regressor.effect
            if effect in (NUISANCE, "te.offset", PARAMETER):
                continue
            named = block.regressor
            if isinstance(named, Named) and named.term.nominal:
                out = _calibrated(out, model, block, fit)
            else:  # in force beyond the nominal terms, and calibrated with them
                rows += [row | whose.get(id(block.regressor), {}) for row in rows_of(model, Chosen(block), fit)]
                known.add(effect)
    rows += _kept(analysis.given.simulation)
    for discovery in found or ():
        for row in discovery.simulation_rows:
            if row["effect"] in LIBRARY and LIBRARY[row["effect"]].nominal:
                out = out.with_term(Term(row["effect"], True, _parameters(row)))
            else:
                rows.append(row)
    for effect in sorted({str(r["effect"]) for r in rows} | known):
        out = out.with_term(_term(effect, [r for r in rows if r["effect"] == effect]))
    if whole is not None:
        out = _with_series(out, whole, found is not None)
    out = _with_reaction(out, analysis.reaction)
    return _with_zeros(out, analysis) if TEMPERATURE in models else out


def _with_reaction(simulation: Simulation, reaction: Reaction | None) -> Simulation:
    """The simulation with how much of the reaction through the transmission error the motor torque holds."""
    if reaction is None or reaction.std is None:
        return simulation
    effect, symbol = REACTION
    term = simulation.terms[effect]
    parameters = {**term.parameters, symbol: Parameter(reaction.share, "1", reaction.std)}
    return simulation.with_term(replace(term, parameters=parameters))


def _with_zeros(simulation: Simulation, analysis: Analysis) -> Simulation:
    """The simulation with what is taken off the loss said in its term."""
    term = simulation.terms.get(EFFECT)
    if term is None or not term.enabled:
        return simulation
    extra = {key: value for key, value in term.extra.items() if key != KEY}
    if analysis.zeros.which:
        extra[KEY] = list(analysis.zeros.which)
    return simulation.with_term(replace(term, extra=extra))


def of_gearbox(simulation: Simulation, gearbox: object) -> Simulation:
    """The simulation with the gearbox of the recordings, as their headers have it."""
    ratio = getattr(gearbox, "ratio", None)
    if ratio is None:
        return simulation
    teeth = [getattr(gearbox, name, None) for name in TEETH]
    return replace(simulation, gearbox=Gearbox(float(ratio), *teeth))


_PERIODIC = ("waves", "law", "orders")


def _kept(simulation: Simulation) -> list[Row]:
    """Rows of a given simulation that are no regressors: they stay as they are."""
    out: list[Row] = []
    for effect, term in simulation.terms.items():
        if effect in LIBRARY and LIBRARY[effect].nominal:
            continue
        for row in term.rows() if term.enabled else ():
            periodic = any(key in row for key in _PERIODIC) or INPUT_ANGLE in row.get("over", ())
            if periodic or effect == "te.local_defect" or row.get("form") == "ripple":
                out.append({"effect": effect, **row})
    return out


def _term(effect: str, rows: Sequence[Row]) -> Term:
    plain = [{key: value for key, value in row.items() if key != "effect"} for row in rows]
    if not plain:
        return Term(effect, False)
    first, *others = plain
    extra = {key: value for key, value in first.items() if key not in ("parameters", "orders")}
    if others:
        extra["also"] = others
    orders = tuple(float(f) for f in first["orders"]) if "orders" in first else None
    return Term(effect, True, _parameters(first), orders, None, extra)


def _parameters(row: Row) -> dict[str, Parameter]:
    out = {}
    for symbol, p in row.get("parameters", {}).items():
        if isinstance(p, Mapping):
            out[symbol] = Parameter(float(p["value"]), str(p.get("unit", "1")), p.get("std"))
        else:
            out[symbol] = Parameter(float(p))
    return out


def _calibrated(out: Simulation, model: ChannelModel, block: Block, fit: Fit) -> Simulation:
    named = block.regressor
    assert isinstance(named, Named)
    assert not isinstance(named, Free)
    train = model.problem.train
    if not np.any(named.columns(model.problem.rows.frame)[train]):
        return out  # nothing in these recordings depends on it: it stays as it was
    coefficients, _ = fit.of(block.indices)
    std = model.std(block.indices, fit)
    values = {
        s.symbol: Parameter(float(v), s.unit, float(d))
        for s, v, d in zip(named.form.linear, coefficients, std, strict=True)
    }
    before = out.terms.get(named.effect, Term(named.effect))
    # a nominal term of two channels keeps what the other one says
    return out.with_term(Term(named.effect, True, {**before.parameters, **values}, None, None, before.extra))


def _with_series(out: Simulation, model: TransmissionModel, whole: bool) -> Simulation:
    """The simulation with the calibrated series and offset, in the paper's coefficients of raw torque, speed,
    temperature.
    """
    offset = _offset(model, whole)
    series = model.plain
    if whole and model.periodic is not None:
        series = model.periodic.series
    sets = [_side(series, side, offset[k]) for k, side in enumerate((1, -1))]
    if model.swings is not None:
        # of a joint that never turns its output round the simulation has an offset and no series
        sets = [replace(FourierSet.zeros(()), offset=level) for level in offset]
    if all(part is None for part in sets):
        return out
    coefficients = TransmissionErrorModel(sets[0], sets[1])
    if out.enabled("te.fourier"):
        first = next(s for s in sets if s is not None)
        out = out.with_term(Term("te.fourier", True, {}, tuple(float(f) for f in first.orders), coefficients))
    if out.enabled("te.offset"):
        out = out.with_term(Term("te.offset", True, {}, None, coefficients))
    return out


def _offset(model: TransmissionModel, whole: bool) -> FloatArray:
    """The offset's coefficients (2, 10) for τ in N·m, θ̇ in rad/s, T in °C; 0 where it is switched off."""
    assert model.offset is not None
    offset_model = model.offset.model
    fit = offset_model.fit if whole else offset_model.refitted([])
    block = next((b for b in offset_model.base if b.regressor.effect == "te.offset"), None)
    if block is None:
        return np.zeros((2, 10))
    scaled = fit.of(block.indices)[0].reshape(2, 10)
    return Standardisation(np.asarray(CENTRE), np.asarray(SPREAD)).to_raw(scaled)


def _side(series: Series | None, side: int, offset: FloatArray) -> FourierSet | None:
    if series is None or side not in series.amplitude:
        return None
    raw = _standardisation(series.scaling[side])
    orders = np.asarray(series.orders)
    by_order = np.argsort(orders)
    amplitude, phase = (raw.to_raw(table[side])[by_order] for table in (series.amplitude, series.phase))
    return FourierSet(orders[by_order], amplitude, phase, offset)


def _standardisation(scaling: Scaling) -> Standardisation:
    return Standardisation(scaling.centre, scaling.spread)
