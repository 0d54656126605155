"""From what is periodic in a model to discoveries: what each adds, its parameters, its rows of a simulation file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import NAMED, Discovery
from bench.mismatch.equations import renamed
from bench.mismatch.orders.defects import Defect, near_defects
from bench.mismatch.orders.misread import ENCODER, Misread
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.modulation import Modulation
from bench.mismatch.orders.periodic import Periodic, Pulse
from bench.mismatch.orders.sight import Sight, known_orders
from bench.mismatch.orders.weak import MODELS, WeakOrder
from bench.mismatch.regression.maxima import tail_rate
from bench.mismatch.regression.strength import active_size
from bench.simulation import Gearbox, waves
from bench.simulation.frame import FloatArray
from bench.simulation.parts import part_of
from bench.simulation.terms import LIBRARY, TRANSMISSION_ERROR

Row = dict[str, Any]
WAVE = "TE += c*cos(f*theta) + s*sin(f*theta)"
AMPLITUDE = "a{0} = sqrt(mean(c{0}**2 + s{0}**2))"
"""of a wave whose amplitude may change with the state"""
OF_MOTOR = ", f = k*u"
MOVES_NOTHING = "the motor's encoder: multiples of the ratio, without the load's reaction in the motor torque"
_DEPENDS = {"p": "direction", "tau": "load", "abs_tau": "load", "v": "speed", "T": "temperature"}


def parameter(symbol: str, value: float, unit: str, std: float | None) -> Row:
    """A parameter as reports have it."""
    return {"symbol": symbol, "value": value, "unit": unit, "std": std}


def probability(p_value: float | None) -> float | None:
    """Probability that what was found is real, at even odds beforehand (Berger and Sellke, JASA 82 (1987) 112).

    The evidence against chance is at most 1/(-e*p*ln p).
    """
    if p_value is None:
        return None
    if p_value >= np.exp(-1.0):
        return 0.5
    odds = -math.e * p_value * np.log(max(p_value, 1e-300))
    return float(1.0 / (1.0 + odds))


def strong(model: TransmissionModel, added: FloatArray) -> bool:
    """Whether what a discovery adds is strong enough, where it acts, to be reported."""
    assert model.noise is not None
    train = model.inside & (model.folds[model.rows.frame.recording] >= 0)
    size = active_size(added[train], model.rows.number[train])
    return bool(size >= criteria.LEAST_STRENGTH * np.sqrt(model.noise.variance))


def of_orders(
    model: TransmissionModel,
    sight: Sight,
    effect: str,
    orders: Sequence[float],
    gearbox: Gearbox,
    p_value: float | None,
    confidence: float | None,
    extra: Mapping[str, Any],
) -> Discovery | None:
    """A discovery of plain orders, strongest first; ``extra``: what else the :class:`Discovery` says. None if it is
    weak.
    """
    if not orders:
        return None
    by_size = sorted((_order(model, sight, f) for f in orders), key=lambda w: -w[1])
    misread = [m for m in model.torque_check.found if m.beside and m.order in orders]
    values = _evaluated(model, orders)
    values = values + waves.evaluate([m.taken_off for m in misread], model.rows.frame.theta, model.rows.frame)
    if not strong(model, values):
        return None
    rows: list[Row] = []
    polynomial = [f for f in orders if model.periodic is not None and f in model.periodic.series.orders]
    alone = [w for w, _ in by_size if w.order not in polynomial]
    if alone:
        wave_rows = [wave.to_json() for w in alone for wave in w.waves()]
        rows.append({"effect": effect, "channels": [TRANSMISSION_ERROR], "waves": wave_rows})
    if polynomial:
        rows.append({"effect": effect, "orders": sorted(polynomial)})
        taken_off = [m.taken_off.to_json() for m in misread if m.order in polynomial]
        if taken_off:
            rows.append({"effect": effect, "channels": [TRANSMISSION_ERROR], "waves": taken_off})
    table = tuple(_table_row(model, w, size, gearbox) for w, size in by_size)
    term = LIBRARY[effect]
    of_motor = OF_MOTOR if effect == ENCODER else ""
    out = Discovery(
        effect=effect,
        status=NAMED,
        confidence=confidence,
        channel=TRANSMISSION_ERROR,
        words=term.name,
        equation=f"{WAVE}{of_motor}, {AMPLITUDE.format('')}",
        variables=("angle",),
        parameters=tuple(_parameters(by_size[0][0], by_size[0][1])),
        added=values,
        gain=float(sum(w.gain for w, _ in by_size)),
        p_value=p_value,
        simulation_rows=tuple(rows),
        orders=tuple(w.order for w, _ in by_size),
        table=table,
        numbers=sum(2 * len(w.model) for w, _ in by_size),
    )
    return replace(out, **extra)


def of_encoder(model: TransmissionModel, parts: Sequence[Misread], words: str) -> Discovery | None:
    """The motor encoder's parts of orders that the gearbox has as well, as a discovery; None if they are weak."""
    values = waves.evaluate([m.wave for m in parts], model.rows.frame.theta, model.rows.frame)
    if not parts or not strong(model, values):
        return None
    by_size = sorted(parts, key=lambda m: -abs(m.vector))
    first, p_value = by_size[0], min(m.p_value for m in parts)
    table = [
        {"order": m.order, "amplitude": abs(m.vector), "unit": "rad", "std": m.std}
        | {"part": "motor encoder", "depends_on": "nothing"}
        for m in by_size
    ]
    row = {"effect": ENCODER, "channels": [TRANSMISSION_ERROR], "waves": [m.wave.to_json() for m in by_size]}
    return Discovery(
        effect=ENCODER,
        status=NAMED,
        confidence=probability(p_value),
        channel=TRANSMISSION_ERROR,
        words=words,
        equation=f"{WAVE}{OF_MOTOR}, {AMPLITUDE.format('')}",
        variables=("angle",),
        parameters=(
            parameter("f", first.order, "1", None),
            parameter("a", abs(first.vector), "rad", first.std),
            parameter("c", first.vector.imag, "rad", first.std),
            parameter("s", first.vector.real, "rad", first.std),
        ),
        added=values,
        gain=float(sum(m.gain for m in parts)),
        p_value=p_value,
        simulation_rows=(row,),
        orders=tuple(m.order for m in by_size),
        table=tuple(table),
        numbers=2 * len(parts),
    )


def _order(model: TransmissionModel, sight: Sight, order: float) -> tuple[WeakOrder, float]:
    """An order as waves, and its root mean square amplitude over the training revolutions (rad), without what the
    motor's encoder misreads of it.
    """
    assert model.periodic is not None
    vectors = sight.at(model, order)
    gain, which = sight.gains(vectors, order)
    estimate = next((w for w in model.periodic.weak if w.order == order), None)
    estimate = estimate or sight.estimated(vectors, order, which, gain)
    estimate = replace(estimate, gain=gain)
    misread = model.torque_check.beside(order)
    if misread:
        constant = np.array([times in ("1", "p", "n") for times in estimate.model])
        estimate = replace(estimate, vectors=np.where(constant, estimate.vectors - misread, estimate.vectors))
    shown = model.periodic.at_revolutions(model.training_revolutions, [order])[:, 0] - misread
    return estimate, float(np.sqrt(np.mean(np.abs(shown) ** 2)))


def _evaluated(model: TransmissionModel, orders: Sequence[float]) -> FloatArray:
    """Sum of some found orders at the model's rows (n,)."""
    assert model.periodic is not None
    periodic, frame = model.periodic, model.rows.frame
    wanted = [wave for w in periodic.weak if w.order in orders for wave in w.waves()]
    out = waves.evaluate(wanted, frame.theta, frame) if wanted else np.zeros(frame.size)
    present = [f for f in periodic.series.orders if f in orders]
    if present:
        part = periodic.series.less([f for f in periodic.series.orders if f not in present])
        out = out + Periodic(part, laws=periodic.laws).evaluate(frame)
    return np.asarray(out)


def _table_row(model: TransmissionModel, order: WeakOrder, size: float, gearbox: Gearbox) -> Row:
    part = part_of(order.order, gearbox, [round(f) for f in model.given.notch])
    names = {
        name for times in order.model for factor in times.split("*") for key, name in _DEPENDS.items() if factor == key
    }
    depends = [name for name in dict.fromkeys(_DEPENDS.values()) if name in names]
    return {
        "order": order.order,
        "amplitude": size,
        "unit": "rad",
        "std": float(np.sqrt(np.mean(order.variances))),
        "part": part,
        "depends_on": ", ".join(depends) or "nothing",
    }


def _parameters(order: WeakOrder, size: float) -> list[Row]:
    """The strongest order's parameters."""
    std = float(np.sqrt(np.mean(order.variances)))
    out = [parameter("f", order.order, "1", None), parameter("a", size, "rad", std)]
    if order.model == MODELS[0]:
        vector = complex(order.vectors[0])
        out += [parameter("c", vector.imag, "rad", std), parameter("s", vector.real, "rad", std)]
    return out


def of_pulses(model: TransmissionModel, defects: Sequence[Defect]) -> Discovery | None:
    """Local defects as one discovery."""
    pulses = tuple(p for d in defects for p in d.form)
    if not pulses:
        return None
    assert model.periodic is not None
    found = [*model.periodic.series.orders, *(w.order for w in model.periodic.weak)]
    # dozens of orders that were found leave of a pulse a little everywhere; they are no part of the simulation
    excess = _beyond_orders(model, pulses, known_orders(model))
    if not strong(model, np.where(near_defects(defects, model.rows.frame.theta), excess, 0.0)):
        return None
    term = LIBRARY["te.local_defect"]
    parameters: list[Row] = []
    equations: list[str] = []
    for number, defect in enumerate(defects):
        first, mark = defect.first, f"_{number + 1}" if len(defects) > 1 else ""
        angle, width, height = first.std or (None, None, None)
        parameters += [
            parameter(f"p{mark}", first.height, "rad", height),
            parameter(f"theta_p{mark}", first.angle, "rad", angle),
            parameter(f"w_p{mark}", first.width, "rad", width),
        ]
        equations.append(renamed(term.equation, {name: f"{name}{mark}" for name in ("p", "theta_p", "w_p")}))
    p_value = max(d.p_value for d in defects)
    return Discovery(
        effect="te.local_defect",
        status=NAMED,
        confidence=probability(p_value),
        channel=TRANSMISSION_ERROR,
        words=term.name,
        equation="; ".join(equations),
        variables=("angle",),
        parameters=tuple(parameters),
        added=_beyond_orders(model, pulses, found),
        excess=excess,
        gain=float(sum(d.gain for d in defects)),
        p_value=p_value,
        simulation_rows=tuple(_pulse_row(p) for p in pulses),
        angle_windows=tuple(d.window for d in defects),
        numbers=3 * len(pulses),
    )


def _beyond_orders(model: TransmissionModel, pulses: Sequence[Pulse], orders: Sequence[float]) -> FloatArray:
    """Pulses less what ``orders`` would take of them if the pulses were not there (n,)."""
    theta = model.rows.frame.theta
    out = np.asarray(sum((p.evaluate(theta) for p in pulses), np.zeros(theta.size)))
    drawn = sum((p.vectors(np.array(orders)) for p in pulses), np.zeros(len(orders), dtype=np.complex128))
    taken = [
        waves.Wave(f, "1", float(v.imag), float(v.real))
        for f, v in zip(orders, np.asarray(drawn), strict=True)
        if f == round(f)
    ]
    level = sum(p.height * p.width for p in pulses) / np.sqrt(2.0 * np.pi)
    return np.asarray(out - waves.evaluate(taken, theta, model.rows.frame) - level)


def _pulse_row(pulse: Pulse) -> Row:
    angle, width, height = pulse.std or (None, None, None)
    parameters = {
        "p": {"value": pulse.height, "unit": "rad", "std": height},
        "theta_p": {"value": pulse.angle, "unit": "rad", "std": angle},
        "w_p": {"value": pulse.width, "unit": "rad", "std": width},
    }
    return {
        "effect": "te.local_defect",
        "form": "gaussian",
        "channels": [TRANSMISSION_ERROR],
        "parameters": parameters,
    }


def modulation_parameters(model: TransmissionModel, sight: Sight, found: Modulation) -> tuple[Row, ...]:
    """Carrier, modulation, and the size of either side."""
    pair = found.pairs[0]
    out = [parameter("f", pair.carrier, "1", None), parameter("m", pair.modulation, "1", None)]
    for name, f in zip(("lower", "upper"), pair.orders, strict=True):
        estimate, size = _order(model, sight, f)
        out.append(parameter(f"a_{name}", size, "rad", float(np.sqrt(np.mean(estimate.variances)))))
    return tuple(out)


def order_p_value(model: TransmissionModel, gain: float) -> float | None:
    """Chance that the best of all orders gains as much in noise: a Gumbel law through surrogates of this folder."""
    return None if model.nulls is None else tail_rate(model.nulls, gain)
