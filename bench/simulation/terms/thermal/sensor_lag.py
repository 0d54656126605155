"""The PT100 lags the lubricant."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

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


def behind(form: Form, frame: Frame, constant: float) -> FloatArray:
    """Energy (n,), J, by which the gearbox is ahead of what a form of the sensor reads: each lag holds back its
    ``constant`` (s) times the loss that has come through it.
    """
    follow: Follow = campaign_lag if form.remembers else lag
    arrived, out = frame.power, np.zeros(frame.size)
    for _ in range(LAGS[form.name.removesuffix("_kept")]):
        arrived = follow(arrived, frame, constant)
        out = out + constant * arrived
    return np.asarray(out)


PER_C = Symbol("1/C", "K/J", "one over the heat capacity", 0.0)
TAU = Symbol("tau_s", "s", "time constant of the sensor", 0.0)
TAU_2 = Symbol("tau_2", "s", "time constant of the sheath and of the element, each", 0.0)

# the sensor is late by what heats, so the heat capacity is that of the lubricant
_LAG = "dT/dt -= 1/C*(P - P_s), tau_s*dP_s/dt = P - P_s, P: loss"
_TWICE = "dT/dt -= 1/C*(P - P_s), tau_2*dP_s/dt = P_1 - P_s, tau_2*dP_1/dt = P - P_1, P: loss"
LAGS = {"first_order": 1, "second_order": 2}
"""lags one behind the other: a sheath and the element inside it are two, about as slow as each other"""

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
                _lagging(follow, LAGS[name]),
                (PER_C,),
                (tau,),
                _grid,
                remembers=follow is campaign_lag,
                equation=f"{text}, {begins}",
                shares=LOSS_HEATING.effect,
            )
            for name, tau, text, states, equal in (
                ("first_order", TAU, _LAG, "P_s", "P_s"),
                ("second_order", TAU_2, _TWICE, "P_s and P_1", "P_s = P_1"),
            )
            # what a warm-up has not yet brought to the sensor comes in the recordings after it
            for follow, suffix, begins in (
                (lag, "", f"{equal} = P at the start of each recording"),
                (campaign_lag, "_kept", f"{states} go{'es' if states == 'P_s' else ''} on between recordings"),
            )
        )
    },
    variables=("transient",),
)
