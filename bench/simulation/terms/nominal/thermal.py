"""Nominal heat balance (equation 3 of the bench), integrated over time."""

from __future__ import annotations

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import integral
from bench.simulation.terms.base import TEMPERATURE, Form, Point, Symbol, Term, columns

PER_C = Symbol("1/C", "K/J", "one over the heat capacity", 0.0)
PER_RC = Symbol("1/(R*C)", "1/s", "one over the time constant", 0.0)
SURROUNDINGS = Symbol("(T_amb-25)/(R*C)", "K/s", "surroundings above 25 degC over the time constant")
REFERENCE = "heat balance of the nominal simulation"


def _heating(frame: Frame, _: Point) -> FloatArray:
    return columns(integral(frame.power, frame) + frame.lead)


def _convection(frame: Frame, _: Point) -> FloatArray:
    # referred to 25 degC, so that the two coefficients are not one another's opposite
    return columns(-integral(frame.temperature - 25.0, frame), frame.elapsed)


LOSS_HEATING = Term(
    effect="thermal.loss_heating",
    name="heating by the loss",
    equation="dT/dt += abs(tau_m*w_m - tau*dq/dt)/C",
    reference=REFERENCE,
    where="temperature, rising with the loss",
    forms={
        TEMPERATURE: (
            Form(
                "nominal",
                _heating,
                (PER_C,),
                equation="dT/dt += 1/C*abs(tau_m*w_m - tau*dq/dt)",
            ),
        )
    },
    nominal=True,
    variables=("speed",),
)
CONVECTION = Term(
    effect="thermal.convection",
    name="cooling to the surroundings",
    equation="dT/dt -= (T - T_amb)/(R*C)",
    reference=REFERENCE,
    where="temperature, falling towards the surroundings'",
    forms={
        TEMPERATURE: (
            Form(
                "nominal",
                _convection,
                (PER_RC, SURROUNDINGS),
                equation="dT/dt += (T_amb-25)/(R*C) - 1/(R*C)*(T - 25 degC)",
            ),
        )
    },
    nominal=True,
    variables=("temperature",),
)
TERMS = (LOSS_HEATING, CONVECTION)
