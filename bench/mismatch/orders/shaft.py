"""Ripple of the input motor: orders of its shaft in its torque, too fast for rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import NAMED, UNKNOWN, UNNAMED, Discovery
from bench.mismatch.orders.lines import Line, Model, Turns, standing
from bench.mismatch.orders.periodicity import (
    LOW_ORDERS,
    Periodicity,
    equation,
    loudness,
    on_rows,
    power,
    squares_of,
    wave_of,
)
from bench.mismatch.orders.reported import parameter, probability
from bench.simulation.frame import FloatArray
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE
from bench.simulation.waves import Wave

Row = dict[str, Any]
RIPPLE = "motor.torque_ripple"
SHAFT_MODELS: tuple[Model, ...] = (("1",), ("motor_torque",))
PHASES = 6
"""an electrical period has so many commutations or phase changes: ripple stands at multiples of them"""


def over_shaft(seen: Periodicity, seed: int) -> list[Discovery]:
    """Ripple of the motor, and orders of its shaft that have no name."""
    if not seen.shaft:
        return []
    torque = np.array([s.torque for s in seen.shaft])
    factors: Mapping[str, FloatArray] = {"1": np.ones(torque.size), "motor_torque": torque}
    sigma = np.array([s.sigma for s in seen.shaft])
    folds = seen.folds[[s.recording for s in seen.shaft]]
    turns = Turns(np.array([s.in_band for s in seen.shaft]), sigma, factors, folds)
    whole = replace(turns, vectors=np.array([s.amplitude for s in seen.shaft]))
    lines = standing(turns, SHAFT_MODELS, seed)
    known = {line.order for line in lines}
    # an order that few recordings are slow enough for is told by the others, in which it is folded
    lines += [line for line in standing(whole, SHAFT_MODELS, seed) if line.order not in known]
    lines = sorted((s for s in lines if s.order * seen.ratio > LOW_ORDERS), key=lambda line: -line.gain)
    ripple = [line for line in lines if line.order % PHASES == 0]
    other = [line for line in lines if line.order % PHASES != 0]
    out = []
    for effect, of_effect in ((RIPPLE, ripple), (UNNAMED, other)):
        if of_effect:
            found = _of_shaft(seen, whole, effect, of_effect)
            if found is not None:
                out.append(found)
    return out


def _equation(effect: str, waves: Sequence[Wave], grows: bool) -> str:
    """Equation of the strongest order, after all orders where they have no name; ``grows``: with the torque."""
    wave = "a_rc*cos(n*u*theta) + a_rs*sin(n*u*theta)"
    wave = f"({wave})*tau_m/tau_r" if grows else wave
    wave += ", a_r = sqrt(a_rc**2 + a_rs**2)"
    return f"tau_m += {wave}" if effect == RIPPLE else f"{equation(waves)}; order n of the shaft: {wave}"


def _of_shaft(seen: Periodicity, turns: Turns, effect: str, lines: Sequence[Line]) -> Discovery | None:
    parts = [(line, (0,)) for line in lines]
    least = criteria.LEAST_STRENGTH * (1.0 if effect == RIPPLE else criteria.NAMELESS)
    if np.sqrt(power(turns, parts)) < least * seen.floor:
        return None
    main = lines[0]
    typical = float(np.sqrt(np.mean(turns.factors["motor_torque"][turns.train] ** 2)))
    rows: list[Row] = []
    waves: list[Wave] = []
    parameters: list[Row] = []
    for line in lines:
        at = typical if line.model == ("motor_torque",) else 0.0
        vector, std = complex(line.amplitude[0]) * (at or 1.0), float(np.sqrt(line.variance[0])) * (at or 1.0)
        waves.append(replace(wave_of(line, 0), order=line.order * seen.ratio))
        amplitudes = [
            parameter("a_rc", vector.real, "N*m", std),
            parameter("a_rs", vector.imag, "N*m", std),
            parameter("n", float(line.order), "1", None),
        ]
        amplitudes += [parameter("tau_r", at, "N*m", None)] if at else []
        if line is main:
            parameters = [parameter("a_r", abs(vector), "N*m", std), *amplitudes]
        by_symbol = {str(p["symbol"]): {"value": p["value"], "unit": p["unit"], "std": p["std"]} for p in amplitudes}
        if effect == RIPPLE:
            rows.append({"effect": effect, "form": "ripple", "channels": [MOTOR_TORQUE], "parameters": by_symbol})
    if effect != RIPPLE:
        rows.append({"effect": effect, "channels": [MOTOR_TORQUE], "waves": [w.to_json() for w in waves]})
    p_value = max(line.p_value for line in lines)
    grows = " in proportion to the torque" if main.model != ("1",) else ""
    words = f"{LIBRARY[RIPPLE].name}{grows}" if effect == RIPPLE else f"order {main.order} of the motor's shaft{grows}"
    return Discovery(
        effect=effect,
        status=NAMED if effect == RIPPLE else UNKNOWN,
        confidence=probability(p_value),
        channel=MOTOR_TORQUE,
        words=words,
        equation=_equation(effect, waves, bool(main.model != ("1",))),
        variables=("angle",),
        parameters=tuple(parameters),
        added=on_rows(waves, seen.rows),
        excess=loudness(waves, seen.rows),
        gain=float(sum(line.gain for line in lines)),
        p_value=p_value,
        simulation_rows=tuple(rows),
        orders=tuple(line.order * seen.ratio for line in lines),
        numbers=2 * len(lines),
        squares=squares_of(seen, turns, parts),
    )
