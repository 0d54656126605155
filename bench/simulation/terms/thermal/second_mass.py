"""A second heat capacity (the housing) between the lubricant and the surroundings."""

from __future__ import annotations

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import campaign_lag, integral, lag
from bench.simulation.terms.base import TEMPERATURE, Form, Point, Symbol, Term, columns, logarithmic


def _grid(_: Frame) -> tuple[Point, ...]:
    return logarithmic(20.0, 8000.0, 14)


def _housing(frame: Frame, point: Point) -> FloatArray:
    return _cooled_by(campaign_lag(frame.temperature, frame, point[0]), frame)


def _rested(frame: Frame, point: Point) -> FloatArray:
    return _cooled_by(lag(frame.temperature, frame, point[0]), frame)


def _cooled_by(housing: FloatArray, frame: Frame) -> FloatArray:
    return columns(-integral(frame.temperature - housing, frame))


RATE = Symbol("1/(R_h*C)", "1/s", "conductance to the housing over the heat capacity", 0.0)
TAU = Symbol("tau_h", "s", "time constant of the housing", 0.0)

TERM = Term(
    effect="thermal.second_mass",
    name="second thermal mass (housing)",
    equation="C*dT/dt = P - (T - T_h)/R_h - (T - T_amb)/R, tau_h*dT_h/dt = T - T_h",
    reference="two-node lumped model, Incropera, Fundamentals of Heat and Mass Transfer, ch. 5",
    where="temperature: fast after a change of the loss, slow later",
    forms={
        TEMPERATURE: (
            Form(
                "two_node",
                _housing,
                (RATE,),
                (TAU,),
                _grid,
                remembers=True,
                equation="dT/dt -= 1/(R_h*C)*(T - T_h), tau_h*dT_h/dt = T - T_h, T_h goes on between recordings",
            ),
            # after pauses that are long for the housing and of unknown length, or in a test that waits for it
            Form(
                "two_node_rested",
                _rested,
                (RATE,),
                (TAU,),
                _grid,
                equation="dT/dt -= 1/(R_h*C)*(T - T_h), tau_h*dT_h/dt = T - T_h, T_h = T before each recording",
            ),
        )
    },
    variables=("transient",),
)
