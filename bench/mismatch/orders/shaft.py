"""Ripple of the input motor: orders of its shaft in its torque, too fast for rows."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import NAMED, UNKNOWN, UNNAMED, Discovery
from bench.mismatch.orders.lines import Line, Model, Revolutions, significant_lines
from bench.mismatch.orders.periodicity import (
    LOW_ORDERS,
    MOST_WAVES,
    Periodicity,
    equation,
    loudness,
    on_rows,
    power,
    squares_of,
    wave_of,
)
from bench.mismatch.orders.reported import parameter, probability
from bench.mismatch.recordings.vibration import ShaftSpectrum
from bench.simulation.frame import FloatArray
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE
from bench.simulation.waves import Wave

Row = dict[str, Any]
RIPPLE = "motor.torque_ripple"
SHAFT_MODELS: tuple[Model, ...] = (
    ("1",),
    ("motor_torque",),
    ("1", "abs_tau"),
    tuple(f"{way}{'*slowness' * power}" for power in (1, 2, 3) for way in "pn"),
)
"""what an order's vector is in proportion to. The last one stands for the drive's loop: what a torque reports of a
ripple inside the loop is the loop's answer at that frequency, which falls as it rises, and its phase turns the other
way in the other direction
"""
PLAIN: tuple[Model, ...] = SHAFT_MODELS[:2]
"""of one vector, which the form of the library has"""
VARIES: Mapping[Model, tuple[str, ...]] = {SHAFT_MODELS[2]: ("load",)}
"""what an order changes with beside the motor torque that it is in proportion to"""
PHASES = 6
"""an electrical period has so many commutations or phase changes: ripple stands at multiples of them"""
OF_A_SPECTRUM: Mapping[str, Callable[[ShaftSpectrum], float]] = {
    "1": lambda s: 1.0,
    "motor_torque": lambda s: s.torque,
    "abs_tau": lambda s: abs(s.load) / 1000.0,
    "p": lambda s: float(s.velocity > 0.0),
    "n": lambda s: float(s.velocity <= 0.0),
    "slowness": lambda s: 1.0 / (1.0 + abs(s.velocity) / 0.1),
}
"""those of :data:`bench.simulation.quantities.FACTORS` that a spectrum over the shaft tells"""


def over_shaft(seen: Periodicity, seed: int) -> list[Discovery]:
    """Ripple of the motor, and orders of its shaft that have no name."""
    if not seen.shaft:
        return []
    shaft, revolutions = shaft_revolutions(seen)
    whole = replace(revolutions, vectors=np.array([s.amplitude for s in shaft]))
    lines = significant_lines(revolutions, SHAFT_MODELS, seed)
    known = {line.order for line in lines}
    # an order that few recordings are slow enough for is told by the others, in which it is folded
    lines += [line for line in significant_lines(whole, SHAFT_MODELS, seed) if line.order not in known]
    lines = sorted((s for s in lines if s.order * seen.ratio > LOW_ORDERS), key=lambda line: -line.gain)
    # the drive's loop follows what its encoder says: what it makes of an error of that is no effect of its own
    lines = [s for s in lines if s.order % PHASES == 0 or s.order not in seen.followed]
    ripple = [line for line in lines if line.order % PHASES == 0]
    other = [line for line in lines if line.order % PHASES != 0]
    out = []
    for effect, of_effect in ((RIPPLE, ripple), (UNNAMED, other)):
        if of_effect:
            found = _of_shaft(seen, whole, effect, of_effect)
            if found is not None:
                out.append(found)
    return out


def shaft_revolutions(seen: Periodicity) -> tuple[list[ShaftSpectrum], Revolutions]:
    """Recordings whose orders of the shaft are compared, and their vectors where an order is not too fast."""
    one_way = [s for s in seen.shaft if s.one_way]
    # where few turn one way only, what depends on the way is not asked
    shaft = one_way if len(one_way) >= 2 * len(SHAFT_MODELS[3]) + 2 else list(seen.shaft)
    return shaft, Revolutions(
        np.array([s.in_band for s in shaft]),
        np.array([s.sigma for s in shaft]),
        factors(shaft, {name for model in SHAFT_MODELS for name in model}),
        seen.folds[[s.recording for s in shaft]],
    )


def factors(shaft: Sequence[ShaftSpectrum], names: Collection[str]) -> Mapping[str, FloatArray]:
    """Factors of waves by name, products of :data:`OF_A_SPECTRUM`, in each recording (recordings,)."""

    def each(part: str) -> FloatArray:
        return np.array([OF_A_SPECTRUM[part](s) for s in shaft])

    return {name: np.prod([each(part) for part in name.split("*")], axis=0) for name in names}


def _equation(effect: str, waves: Sequence[Wave], main: Line, over: str) -> str:
    """Equation of the strongest order over the motor's angle as the file has it: after some orders where they have no
    name, with all its waves where it has more than one vector.
    """
    if main.model not in PLAIN:
        of_order = [w for w in waves if w.order == waves[0].order]
        return f"tau_m {equation(of_order, over)}; order n of the shaft: a_r its root mean square amplitude"
    wave = "a_rc*cos(n*u*theta) + a_rs*sin(n*u*theta)"
    wave = f"({wave})*tau_m/tau_r" if main.model == PLAIN[1] else wave
    wave += ", a_r = sqrt(a_rc**2 + a_rs**2)"
    named = f"tau_m += {wave}"
    return named if effect == RIPPLE else f"{equation(waves[:MOST_WAVES], over)}; order n of the shaft: {wave}"


def _words(effect: str, main: Line) -> str:
    grows = {
        PLAIN[0]: "",
        PLAIN[1]: " in proportion to the torque",
        SHAFT_MODELS[2]: " that grows with the size of the load",
    }
    how = grows.get(main.model, " as the drive's loop answers it at each speed")
    return f"{LIBRARY[RIPPLE].name}{how}" if effect == RIPPLE else f"order {main.order} of the motor's shaft{how}"


def _of_line(line: Line, revolutions: Revolutions, typical: float) -> tuple[list[Row], list[Row]]:
    """An order's parameters of one vector, if it has one (at the ``typical`` torque, where it grows with that); and all
    that a report says of it.
    """
    n = parameter("n", float(line.order), "1", None)
    if line.model not in PLAIN:
        x = np.column_stack([revolutions.factors[t][revolutions.train] for t in line.model])
        size = float(np.sqrt(np.mean(np.abs(x @ line.amplitude) ** 2)))
        std = float(np.sqrt(np.mean(np.sum((x @ line.covariance) * x, axis=1))))
        return [], [parameter("a_r", size, "N*m", std), n]
    at = typical if line.model == PLAIN[1] else 0.0
    vector, std = complex(line.amplitude[0]) * (at or 1.0), float(np.sqrt(line.variance[0])) * (at or 1.0)
    parameters = [parameter("a_rc", vector.real, "N*m", std), parameter("a_rs", vector.imag, "N*m", std), n]
    parameters += [parameter("tau_r", at, "N*m", None)] if at else []
    return parameters, [parameter("a_r", abs(vector), "N*m", std), *parameters]


def _of_shaft(seen: Periodicity, revolutions: Revolutions, effect: str, lines: Sequence[Line]) -> Discovery | None:
    parts = [(line, tuple(range(len(line.model)))) for line in lines]
    least = criteria.LEAST_STRENGTH * (1.0 if effect == RIPPLE else criteria.NAMELESS)
    if np.sqrt(power(revolutions, parts)) < least * seen.floor:
        return None
    main = lines[0]
    direct = seen.ratio == 1.0  # then the shaft's orders are the output's, and waves are over that
    typical = float(np.sqrt(np.mean(revolutions.factors["motor_torque"][revolutions.train] ** 2)))
    rows: list[Row] = []
    waves: list[Wave] = []
    parameters: list[Row] = []
    for line in lines:
        line_waves = [replace(wave_of(line, k), order=line.order * seen.ratio) for k in range(len(line.model))]
        waves += line_waves
        of_form, of_line = _of_line(line, revolutions, typical)
        if line is main:
            parameters = of_line
        if effect == RIPPLE and of_form:
            by_symbol = {str(p["symbol"]): {"value": p["value"], "unit": p["unit"], "std": p["std"]} for p in of_form}
            rows.append({"effect": effect, "form": "ripple", "channels": [MOTOR_TORQUE], "parameters": by_symbol})
        else:
            wave_rows = [w.to_json() for w in line_waves]
            form = {} if direct else {"form": "ripple"}
            rows.append({"effect": effect, **form, "channels": [MOTOR_TORQUE], "waves": wave_rows})
    p_value = max(line.p_value for line in lines)
    return Discovery(
        effect=effect,
        status=NAMED if effect == RIPPLE else UNKNOWN,
        confidence=probability(p_value),
        channel=MOTOR_TORQUE,
        words=_words(effect, main),
        equation=_equation(effect, waves, main, "q" if direct else "theta"),
        variables=("angle", *VARIES.get(main.model, ())),
        parameters=tuple(parameters),
        added=on_rows(waves, seen.rows, seen.rows.frame.theta),
        excess=loudness(waves, seen.rows),
        gain=float(sum(line.gain for line in lines)),
        p_value=p_value,
        simulation_rows=tuple(rows),
        orders=tuple(line.order * seen.ratio for line in lines),
        numbers=2 * sum(len(line.model) for line in lines),
        squares=squares_of(seen, revolutions, parts),
    )
