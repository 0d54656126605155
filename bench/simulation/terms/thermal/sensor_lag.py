"""The PT100 lags the lubricant."""

from __future__ import annotations

from collections.abc import Callable

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import campaign_lag, integral, lag
from bench.simulation.terms.base import TEMPERATURE, Columns, Form, Point, Symbol, Term, columns, logarithmic
from bench.simulation.terms.nominal.thermal import LOSS_HEATING

Follow = Callable[[FloatArray, Frame, float], FloatArray]


def _grid(_: Frame) -> tuple[Point, ...]:
    return logarithmic(1.0, 400.0, 14)


def _lagging(follow: Follow, times: int) -> Columns:
    def regressors(frame: Frame, point: Point) -> FloatArray:
        arrived = frame.power
        for _ in range(times):
            arrived = follow(arrived, frame, point[0])
        # the balance filtered by the sensor: what the lagging power has not yet brought
        return columns(-integral(frame.power - arrived, frame) - frame.lead)

    return regressors


PER_C = Symbol("1/C", "K/J", "one over the heat capacity", 0.0)
TAU = Symbol("tau_s", "s", "time constant of the sensor", 0.0)

# the sensor is late by what heats, so the heat capacity is that of the lubricant
_LAG = "dT/dt -= 1/C*(P - P_s), tau_s*dP_s/dt = P - P_s, P: loss"
_TWICE = "dT/dt -= 1/C*(P - P_s), tau_s*dP_s/dt = P_1 - P_s, tau_s*dP_1/dt = P - P_1, P: loss"

TERM = Term(
    effect="thermal.sensor_lag",
    name="lag of the temperature sensor",
    equation="tau_s*dT_s/dt = T - T_s: the PT100 reads T_s; or twice, through a sheath",
    reference="IEC 60751, response time; Incropera, Fundamentals of Heat and Mass Transfer, ch. 5",
    where="temperature in the first minutes after the loss changes",
    forms={
        TEMPERATURE: tuple(
            Form(
                f"{name}{suffix}",
                _lagging(follow, times),
                (PER_C,),
                (TAU,),
                _grid,
                remembers=follow is campaign_lag,
                equation=f"{text}, P_s {begins}",
                shares=LOSS_HEATING.effect,
            )
            # a sheath and the element inside it are two lags, about as slow as each other
            for name, times, text in (("first_order", 1, _LAG), ("second_order", 2, _TWICE))
            # what a warm-up has not yet brought to the sensor comes in the recordings after it
            for follow, suffix, begins in (
                (lag, "", "= P at the start of each recording"),
                (campaign_lag, "_kept", "goes on between recordings"),
            )
        )
    },
    variables=("transient",),
)
