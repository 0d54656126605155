"""Surroundings that warm or cool."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import integral
from bench.simulation.terms.base import TEMPERATURE, Form, Point, Symbol, Term, columns

CYCLES = (0.5, 0.83, 1.25, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0)
"""periods of the surroundings in a campaign that are tried, half a cycle apart: from half a day to an air conditioning
that comes six times
"""
BEGINS = (0.0, 0.15, 0.3, 0.45, 0.6, 0.75)
"""parts of a campaign after which a heating of the hall is switched on or off, or a door opened"""
LASTS = (0.03, 0.1, 0.3)
"""parts of a campaign within which the hall then comes two thirds of the way"""
SHORTEST_H = 1e-3
"""time constant of a hall below which none is told from a step"""


def _hours(frame: Frame) -> FloatArray:
    return frame.time / 3600.0


def _linear(frame: Frame, _: Point) -> FloatArray:
    return columns(integral(_hours(frame), frame))


def _quadratic(frame: Frame, _: Point) -> FloatArray:
    hours = _hours(frame)
    return columns(integral(hours, frame), integral(hours**2, frame))


def _periods(frame: Frame) -> tuple[Point, ...]:
    span = float(_hours(frame).max()) or 1.0
    return tuple((span / cycles,) for cycles in CYCLES)


def _wave(frame: Frame, point: Point) -> FloatArray:
    phase = 2.0 * np.pi * _hours(frame) / point[0]
    return columns(integral(np.cos(phase), frame), integral(np.sin(phase), frame))


def _changes(frame: Frame) -> tuple[Point, ...]:
    span = float(_hours(frame).max()) or 1.0
    return tuple((span * begins, span * lasts) for begins in BEGINS for lasts in LASTS)


def _settling(frame: Frame, point: Point) -> FloatArray:
    begins, constant = point
    since = np.maximum(_hours(frame) - begins, 0.0)
    return columns(integral(1.0 - np.exp(-since / max(constant, SHORTEST_H)), frame))


D_1 = Symbol("d_1", "K/(s*h)", "drift of the surroundings an hour, over R*C")
D_2 = Symbol("d_2", "K/(s*h^2)", "curvature of the drift, over R*C")
D_C = Symbol("d_c", "K/s", "cosine amplitude over R*C")
D_S = Symbol("d_s", "K/s", "sine amplitude over R*C")
D_E = Symbol("d_e", "K/s", "change of the surroundings in the end, over R*C")
BEGIN = Symbol("t_b", "h", "time after which the surroundings change")
SETTLE = Symbol("t_e", "h", "time constant of the change", 0.0)
PERIOD = Symbol("period", "h", "period of the surroundings", 0.0)

TERM = Term(
    effect="thermal.ambient_drift",
    name="surroundings that warm or cool",
    equation="T_amb = T_0 + T_1*t (+ T_2*t**2, or a wave, or a change that settles)",
    reference="boundary condition of the lumped model",
    where="temperature, by the time of day and not by the bench's state",
    forms={
        TEMPERATURE: (
            Form("linear", _linear, (D_1,), equation="dT/dt += d_1*t"),
            Form("quadratic", _quadratic, (D_1, D_2), equation="dT/dt += d_1*t + d_2*t**2"),
            Form(
                "wave",
                _wave,
                (D_C, D_S),
                (PERIOD,),
                _periods,
                equation="dT/dt += d_c*cos(2*pi*t/period) + d_s*sin(2*pi*t/period)",
            ),
            Form(
                "settling",
                _settling,
                (D_E,),
                (BEGIN, SETTLE),
                _changes,
                equation="dT/dt += d_e*(1 - exp(-max(t - t_b, 0)/t_e))",
            ),
        )
    },
    variables=("time",),
    shape={TEMPERATURE: (("time", "1"),)},
    any_function=True,
)
