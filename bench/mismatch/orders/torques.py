"""What is periodic in the torques and not in their simulation, as discoveries.

Over the output angle: gravity on an unbalanced mass (once a revolution, the same in both directions), friction that
depends on the angle (it changes sign with the direction). Over the motor's angle: torque ripple at multiples of six
times the pole pairs. What stands otherwise has no name.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import AMBIGUOUS, NAMED, UNKNOWN, UNNAMED, Discovery, RefittedAlternative
from bench.mismatch.orders.lines import Line, Model, Revolutions, significant_lines
from bench.mismatch.orders.periodicity import (
    LOW_ORDERS,
    MOST_WAVES,
    Periodicity,
    equation,
    on_rows,
    power,
    squares_of,
    times,
    wave_of,
)
from bench.mismatch.orders.reported import parameter
from bench.mismatch.orders.shaft import over_shaft
from bench.mismatch.recordings.output_orders import OutputSpectrum
from bench.simulation.frame import IntArray
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE
from bench.simulation.waves import Wave

Row = dict[str, Any]
LOAD = "tau"
"""factor of what goes with the load"""
UNBALANCE, FRICTION = "load.unbalance", "friction.position_dependent"
OUTPUT_MODELS: tuple[Model, ...] = (
    ("1",),
    ("d",),
    ("d*abs_tau",),
    ("tau",),
    ("d", "d*abs_tau"),
    ("1", "d"),
    ("1", "tau"),
)
"""factors that an order's vector over the output angle may be in proportion to, the plainest first"""


def torque_discoveries(seen: Periodicity, seed: int) -> list[Discovery]:
    """Everything periodic in a torque beyond its simulation, strongest first; each has the waves that it is."""
    out = over_shaft(seen, seed) if seen.channel == MOTOR_TORQUE else []
    # of a direct drive the orders of the shaft are those of the output
    taken = {f for found in out for f in found.orders}
    out += _over_output(seen, seed, taken)
    return sorted(out, key=lambda d: -d.gain)


def _over_output(seen: Periodicity, seed: int, taken: Collection[float]) -> list[Discovery]:
    if not seen.output:
        return []
    revolutions = output_revolutions(seen.output, seen.folds)
    lines = [
        s
        for s in significant_lines(revolutions, OUTPUT_MODELS, seed)
        # no function of the rows goes with the load and the angle
        if (s.order > LOW_ORDERS or LOAD in s.model) and s.order not in taken
    ]
    one_way = len({s.direction for s, t in zip(seen.output, revolutions.train, strict=True) if t}) < 2
    by_effect: dict[str, list[tuple[Line, tuple[int, ...]]]] = {}
    for line in lines:
        for k, factor in enumerate(line.model):
            if line.order <= LOW_ORDERS and factor != LOAD:
                continue  # what the rows show is found among them
            effect = name_of(seen.channel, line.order, factor)
            lines_of_effect = by_effect.setdefault(effect, [])
            if lines_of_effect and lines_of_effect[-1][0] is line:
                lines_of_effect[-1] = (line, (*lines_of_effect[-1][1], k))
            else:
                lines_of_effect.append((line, (k,)))
    out = []
    for effect, parts in by_effect.items():
        found = _discovery(seen, revolutions, effect, parts, one_way)
        if found is not None:
            out.append(found)
    return out


def output_revolutions(spectra: Sequence[OutputSpectrum], folds: IntArray) -> Revolutions:
    """Revolutions of a torque over the output angle."""
    direction = np.array([s.direction for s in spectra])
    load = np.array([s.torque for s in spectra]) / 1000.0
    factors = {"1": np.ones(direction.size), "d": direction, "tau": load, "d*abs_tau": direction * np.abs(load)}
    vectors = np.array([s.amplitude for s in spectra]).reshape(direction.size, -1)
    sigma = np.array([s.sigma for s in spectra])
    return Revolutions(
        vectors, sigma, factors, folds[[s.recording for s in spectra]] if spectra else np.zeros(0, dtype=np.int64)
    )


def name_of(channel: str, order: int, factor: str) -> str:
    """Effect that an order of a torque in proportion to ``factor`` is."""
    if factor == "1" and order == 1:
        return UNBALANCE
    if factor in ("d", "d*abs_tau") and channel == MOTOR_TORQUE:
        return FRICTION
    return UNNAMED


def _discovery(
    seen: Periodicity,
    revolutions: Revolutions,
    effect: str,
    parts: Sequence[tuple[Line, tuple[int, ...]]],
    one_way: bool,
) -> Discovery | None:
    waves = [wave_of(line, k) for line, members in parts for k in members]
    squares = squares_of(seen, revolutions, parts)
    size = np.sqrt(max(power(revolutions, parts), 0.0))
    if size < criteria.LEAST_STRENGTH * seen.floor:
        return None
    main, members = parts[0]
    confidence: float | None
    confidence, alternatives = _weighed(seen.channel, effect, main)
    status = NAMED if effect != UNNAMED else UNKNOWN
    if one_way and effect in (UNBALANCE, FRICTION):
        status = AMBIGUOUS
        other = FRICTION if effect == UNBALANCE else UNBALANCE
        if main.order == 1 and seen.channel == MOTOR_TORQUE:
            unknown = float("nan")
            confidence, alternatives = (
                None,
                (RefittedAlternative(other, LIBRARY[other].name, unknown, unknown, unknown, True),),
            )
        else:
            status = NAMED
    term = LIBRARY.get(effect)
    return Discovery(
        effect=effect,
        status=status,
        confidence=confidence,
        channel=seen.channel,
        words=LIBRARY[effect].name if term is not None else _unnamed(main, members),
        equation=_equation(seen.channel, effect, main.model[members[0]], waves),
        variables=("angle",) if effect != UNNAMED or main.model == ("1",) else ("angle", "torque"),
        parameters=tuple(_parameters(seen, effect, main, members)),
        added=on_rows(waves, seen.rows),
        gain=float(sum(line.gain for line, _ in parts)),
        p_value=max(line.p_value for line, _ in parts),
        simulation_rows=tuple(_rows(seen, effect, waves)),
        alternatives=alternatives,
        orders=tuple(float(line.order) for line, _ in parts),
        numbers=2 * len(waves),
        squares=squares,
    )


def _equation(channel: str, effect: str, factor: str, waves: Sequence[Wave]) -> str:
    """Equation of the strongest order, after all orders where they have no name."""
    if effect == UNBALANCE:
        function = "m_s*sin(q) + m_c*cos(q)"
        left = f"tau_m += ({function})/u" if channel == MOTOR_TORQUE else f"{channel} += {function}"
        return f"{left}, m_u = sqrt(m_s**2 + m_c**2)"
    if effect == FRICTION:
        return f"tau_m += {times(factor, 'f_pc*cos(m*q) + f_ps*sin(m*q)')}"
    return f"{equation(waves[:MOST_WAVES])}; order f: {times(factor, 'c*cos(f*q) + s*sin(f*q)')}"


def _unnamed(line: Line, terms: tuple[int, ...]) -> str:
    grows = "in proportion to the load" if any("tau" in line.model[k] for k in terms) else "with the output angle"
    return f"order {line.order} of the output {grows}"


def _weighed(channel: str, effect: str, line: Line) -> tuple[float, tuple[RefittedAlternative, ...]]:
    """Weight of the models of the strongest order that have the effect; the others as alternatives, by effect."""
    total = 0.0
    best: dict[str, RefittedAlternative] = {}
    for model, share in line.shares.items():
        effects = {name_of(channel, line.order, t) for t in model}
        if effect in effects:
            total += share
            continue
        loss, error = line.losses[model]
        for other in effects:
            weight = share + (best[other].weight if other in best else 0.0)
            least = min((loss, error), (best[other].loss, best[other].error)) if other in best else (loss, error)
            words = LIBRARY[other].name if other in LIBRARY else "an order without a name"
            best[other] = RefittedAlternative(other, words, least[0], least[1], weight, least[0] < least[1])
    return total, tuple(best.values())


def _parameters(seen: Periodicity, effect: str, line: Line, terms: tuple[int, ...]) -> list[Row]:
    """Parameters of the strongest order."""
    k = terms[0]
    vector, std = complex(line.amplitude[k]), float(np.sqrt(line.variance[k]))
    if effect == UNBALANCE:
        scale = seen.ratio if seen.channel == MOTOR_TORQUE else 1.0
        return [
            parameter("m_u", abs(vector) * scale, "N*m", std * scale),
            parameter("m_s", vector.imag * scale, "N*m", std * scale),
            parameter("m_c", vector.real * scale, "N*m", std * scale),
        ]
    names = ("f_pc", "f_ps", "m") if effect == FRICTION else ("c", "s", "f")
    return [
        parameter(names[0], vector.real, "N*m", std),
        parameter(names[1], vector.imag, "N*m", std),
        parameter(names[2], float(line.order), "1", None),
    ]


def _rows(seen: Periodicity, effect: str, waves: Sequence[Wave]) -> list[Row]:
    """Rows of a simulation file."""
    if effect == UNBALANCE:
        scale = seen.ratio if seen.channel == MOTOR_TORQUE else 1.0
        return [
            _row(
                effect,
                "gravity",
                seen.channel,
                (("m_s", w.sine * scale, "N*m"), ("m_c", w.cosine * scale, "N*m")),
                w,
                scale,
            )
            for w in waves
        ]
    if effect == FRICTION:
        forms = {"d": "constant", "d*abs_tau": "with_load"}
        return [
            _row(
                effect,
                forms[w.times],
                seen.channel,
                (("f_pc", w.cosine, "N*m"), ("f_ps", w.sine, "N*m"), ("m", w.order, "1")),
                w,
                1.0,
            )
            for w in waves
        ]
    return [{"effect": effect, "channels": [seen.channel], "waves": [w.to_json() for w in waves]}]


def _row(
    effect: str, form: str, channel: str, values: Sequence[tuple[str, float, str]], wave: Wave, scale: float
) -> Row:
    std = None if wave.cosine_std is None else wave.cosine_std * scale
    parameters = {s: {"value": v, "unit": u, "std": std if u != "1" else None} for s, v, u in values}
    return {"effect": effect, "form": form, "channels": [channel], "parameters": parameters}
