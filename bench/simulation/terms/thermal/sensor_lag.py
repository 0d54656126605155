"""The PT100 lags the lubricant."""

from __future__ import annotations

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import followed, integral, lag, loss_lag
from bench.simulation.terms.base import TEMPERATURE, Form, Point, Symbol, Term, columns, logarithmic
from bench.simulation.terms.nominal.thermal import LOSS_HEATING

SLOWER = 5.0
"""how many times as slow the slower of two lags is, where a search begins"""
SHARES = (0.15, 0.4)
"""shares of what the sensor reads that come by the slower one, where a search begins"""


def _grid(_: Frame) -> tuple[Point, ...]:
    return logarithmic(1.0, 400.0, 14)


def _lagging(frame: Frame, point: Point) -> FloatArray:
    # the balance filtered by the sensor: what the lagging power has not yet brought
    return columns(-integral(frame.power - lag(frame.power, frame, point[0]), frame) - frame.lead)


def _lagging_on(frame: Frame, point: Point) -> FloatArray:
    # what a warm-up has not yet brought to the sensor comes in the recordings after it
    return columns(-integral(frame.power - loss_lag(frame, point[0]), frame) - frame.lead)


def lags_of(point: Point) -> tuple[tuple[float, float], ...]:
    """Time constants in s of a lag's nonlinear parameters, each with its share."""
    if len(point) == 1:
        return ((point[0], 1.0),)
    fast, slow, share = point
    return (fast, 1.0 - share), (slow, share)


def _two_grid(frame: Frame) -> tuple[Point, ...]:
    return tuple((fast, SLOWER * fast, share) for (fast,) in _grid(frame)[::2] for share in SHARES)


def _late(x: FloatArray, frame: Frame, point: Point) -> FloatArray:
    # what the sensor has not yet read of a change since the recording began
    return x - sum(share * followed(x, frame, constant) for constant, share in lags_of(point))


def _reading_late(frame: Frame, point: Point) -> FloatArray:
    by_heat = _late(integral(frame.power, frame), frame, point)
    by_cooling = _late(integral(frame.temperature - 25.0, frame), frame, point)
    return columns(-by_heat - frame.lead, by_cooling, -_late(frame.elapsed, frame, point))


def _two_lagging(frame: Frame, point: Point) -> FloatArray:
    (fast, of_fast), (slow, of_slow) = lags_of(point)
    late = of_fast * lag(frame.power, frame, fast) + of_slow * lag(frame.power, frame, slow)
    return columns(-integral(frame.power - late, frame) - frame.lead)


def _two_lagging_on(frame: Frame, point: Point) -> FloatArray:
    (fast, of_fast), (slow, of_slow) = lags_of(point)
    late = of_fast * loss_lag(frame, fast) + of_slow * loss_lag(frame, slow)
    return columns(-integral(frame.power - late, frame) - frame.lead)


PER_C = Symbol("1/C", "K/J", "one over the heat capacity", 0.0)
TAU = Symbol("tau_s", "s", "time constant of the sensor", 0.0)
TAU_2 = Symbol("tau_2", "s", "second, larger time constant of the sensor", 0.0)
SHARE = Symbol("g", "1", "share of the second time constant", 0.0, 1.0)

PER_RC = Symbol("1/(R*C)", "1/s", "one over the time constant of cooling", 0.0)
SURROUNDINGS = Symbol("(T_amb-25)/(R*C)", "K/s", "surroundings above 25 degC over the time constant of cooling")

# in a pocket, or where heat creeps along its sheath, a sensor has no one time constant
_TWO = "dT/dt -= 1/C*(P - (1 - g)*P_1 - g*P_2), tau_s*dP_1/dt = P - P_1, tau_2*dP_2/dt = P - P_2, P: loss"
# the sensor is late by what heats, so the heat capacity is that of the lubricant
SETTLED = ("first_order_settled", "two_lags_settled")
"""forms of a sensor that reads right when a recording begins: what waited long enough before it, or was set so"""
_READS_RIGHT = (
    "T -= D - lag(D), D: integral of 1/C*P + (T_amb-25)/(R*C) - 1/(R*C)*(T - 25 degC) in the recording so far, P: loss;"
)
_LAG = "dT/dt -= 1/C*(P - P_s), tau_s*dP_s/dt = P - P_s, P: loss"

TERM = Term(
    effect="thermal.sensor_lag",
    name="lag of the temperature sensor",
    equation="tau_s*dT_s/dt = T - T_s: the PT100 reads T_s",
    reference="IEC 60751, response time; Incropera, Fundamentals of Heat and Mass Transfer, ch. 5",
    where="temperature in the first minutes after the loss changes",
    forms={
        TEMPERATURE: (
            Form(
                "first_order",
                _lagging,
                (PER_C,),
                (TAU,),
                _grid,
                equation=f"{_LAG}, P_s = P at the start of each recording",
                shares=LOSS_HEATING.effect,
            ),
            Form(
                "first_order_kept",
                _lagging_on,
                (PER_C,),
                (TAU,),
                _grid,
                remembers=True,
                equation=f"{_LAG}, P_s goes on between recordings, with P = 0 before one that begins at rest",
                shares=LOSS_HEATING.effect,
            ),
            Form(
                "two_lags_kept",
                _two_lagging_on,
                (PER_C,),
                (TAU, TAU_2, SHARE),
                _two_grid,
                remembers=True,
                equation=f"{_TWO}, P_1 and P_2 go on between recordings, with P = 0 before one that begins at rest",
                shares=LOSS_HEATING.effect,
            ),
            Form(
                SETTLED[0],
                _reading_late,
                (PER_C, PER_RC, SURROUNDINGS),
                (TAU,),
                _grid,
                equation=f"{_READS_RIGHT} lag of first order with tau_s, from D = 0",
                shares=LOSS_HEATING.effect,
            ),
            Form(
                SETTLED[1],
                _reading_late,
                (PER_C, PER_RC, SURROUNDINGS),
                (TAU, TAU_2, SHARE),
                _two_grid,
                equation=f"{_READS_RIGHT} lag: (1 - g) of first order with tau_s, g with tau_2, from D = 0",
                shares=LOSS_HEATING.effect,
            ),
            Form(
                "two_lags",
                _two_lagging,
                (PER_C,),
                (TAU, TAU_2, SHARE),
                _two_grid,
                equation=f"{_TWO}, P_1 = P_2 = P at the start of each recording",
                shares=LOSS_HEATING.effect,
            ),
        )
    },
    variables=("transient",),
)
