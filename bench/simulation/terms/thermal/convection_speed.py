"""Cooling that grows with speed."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import integral
from bench.simulation.terms.base import TEMPERATURE, Form, Point, Symbol, Term, columns


def _exponents(_: Frame) -> tuple[Point, ...]:
    return ((0.5,), (0.8,), (1.0,), (2.0,))


def _forced(frame: Frame, point: Point) -> FloatArray:
    speed = np.abs(frame.omega / 100.0) ** point[0]
    return columns(-integral(speed * frame.temperature, frame), integral(speed, frame))


SURROUNDINGS_C = (-40.0, 60.0)
"""degC of the air about a bench: wider than any room one stands in, to refuse only what cannot be"""
H_1 = Symbol("h_1", "1/s", "cooling at 100 rad/s of the motor over the heat capacity", 0.0)
H_0 = Symbol("h_1*T_amb", "K/s", "the same times the temperature of the surroundings")
EXPONENT = Symbol("n", "1", "exponent of the speed", 0.1, 3.0)

TERM = Term(
    effect="thermal.convection_speed",
    name="cooling that grows with speed",
    equation="C*dT/dt -= C*h_1*(abs(w_m)/(100 rad/s))**n*(T - T_amb)",
    reference="forced convection, Incropera, Fundamentals of Heat and Mass Transfer, ch. 7",
    where="temperature, while turning fast and warm",
    forms={
        TEMPERATURE: (
            Form(
                "power",
                _forced,
                (H_1, H_0),
                (EXPONENT,),
                _exponents,
                ratio=SURROUNDINGS_C,
                equation="dT/dt += (h_1*T_amb - h_1*T)*(abs(w_m)/(100 rad/s))**n",
            ),
        )
    },
    variables=("speed", "temperature"),
)
