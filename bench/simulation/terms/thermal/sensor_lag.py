"""The PT100 lags the lubricant."""

from __future__ import annotations

from collections.abc import Callable

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import followed, integral, lag, loss_lag
from bench.simulation.terms.base import TEMPERATURE, Form, Point, Symbol, Term, columns, logarithmic
from bench.simulation.terms.nominal.thermal import LOSS_HEATING, PER_C, PER_RC, SURROUNDINGS

SLOWER = 5.0
"""how many times as slow the slower of two lags is, where a search begins"""
SHARES = (0.15, 0.4)
"""shares of what the sensor reads that come by the slower one, where a search begins"""


def _grid(_: Frame) -> tuple[Point, ...]:
    return logarithmic(1.0, 400.0, 14)


def lags_of(point: Point) -> tuple[tuple[float, float], ...]:
    """Time constants in s of a lag's nonlinear parameters, each with its share."""
    if len(point) == 1:
        return ((point[0], 1.0),)
    fast, slow, share = point
    return (fast, 1.0 - share), (slow, share)


def _two_grid(frame: Frame) -> tuple[Point, ...]:
    return tuple((fast, SLOWER * fast, share) for (fast,) in _grid(frame)[::2] for share in SHARES)


def _mean(of_one: Callable[[float], FloatArray], point: Point) -> FloatArray:
    # of what each time constant makes, by their shares
    first, *others = (share * of_one(constant) for constant, share in lags_of(point))
    return sum(others, first)


def _lacking(frame: Frame, late: FloatArray) -> FloatArray:
    # the balance filtered by the sensor: what the lagging power has not yet brought
    return columns(-integral(frame.power - late, frame) - frame.lead)


def _lagging(frame: Frame, point: Point) -> FloatArray:
    return _lacking(frame, _mean(lambda constant: lag(frame.power, frame, constant), point))


def _lagging_on(frame: Frame, point: Point) -> FloatArray:
    # what a warm-up has not yet brought to the sensor comes in the recordings after it
    return _lacking(frame, _mean(lambda constant: loss_lag(frame, constant), point))


def _reading_late(frame: Frame, point: Point) -> FloatArray:
    def late(x: FloatArray) -> FloatArray:
        # what the sensor has not yet read of a change since the recording began
        return x - _mean(lambda constant: followed(x, frame, constant), point)

    by_heat, by_cooling = late(integral(frame.power, frame)), late(integral(frame.temperature - 25.0, frame))
    return columns(-by_heat - frame.lead, by_cooling, -late(frame.elapsed))


TAU = Symbol("tau_s", "s", "time constant of the sensor", 0.0)
TAU_2 = Symbol("tau_2", "s", "second, larger time constant of the sensor", 0.0)
SHARE = Symbol("g", "1", "share of the second time constant", 0.0, 1.0)
HEATED, BALANCE = (PER_C,), (PER_C, PER_RC, SURROUNDINGS)
"""what a lag depends on: the heating alone, or all of the balance"""

# in a pocket, or where heat creeps along its sheath, a sensor has no one time constant
_TWO = "dT/dt -= 1/C*(P - (1 - g)*P_1 - g*P_2), tau_s*dP_1/dt = P - P_1, tau_2*dP_2/dt = P - P_2, P: loss"
SETTLED = ("first_order_settled", "two_lags_settled")
"""forms of a sensor that reads right when a recording begins: what waited long enough before it, or was set so"""
_READS_RIGHT = (
    "T -= D - lag(D), D: integral of 1/C*P + (T_amb-25)/(R*C) - 1/(R*C)*(T - 25 degC) in the recording so far, P: loss;"
)
# the sensor is late by what heats, so the heat capacity is that of the lubricant
_LAG = "dT/dt -= 1/C*(P - P_s), tau_s*dP_s/dt = P - P_s, P: loss"
_KEPT = "on between recordings, with P = 0 before one that begins at rest"


def _form(
    name: str,
    by: Callable[[Frame, Point], FloatArray],
    linear: tuple[Symbol, ...],
    equation: str,
    remembers: bool = False,
) -> Form:
    two = name.startswith("two_lags")
    return Form(
        name,
        by,
        linear,
        (TAU, TAU_2, SHARE) if two else (TAU,),
        _two_grid if two else _grid,
        remembers=remembers,
        equation=equation,
        shares=LOSS_HEATING.effect,
    )


TERM = Term(
    effect="thermal.sensor_lag",
    name="lag of the temperature sensor",
    equation="tau_s*dT_s/dt = T - T_s: the PT100 reads T_s",
    reference="IEC 60751, response time; Incropera, Fundamentals of Heat and Mass Transfer, ch. 5",
    where="temperature in the first minutes after the loss changes",
    forms={
        TEMPERATURE: (
            _form("first_order", _lagging, HEATED, f"{_LAG}, P_s = P at the start of each recording"),
            _form("first_order_kept", _lagging_on, HEATED, f"{_LAG}, P_s goes {_KEPT}", remembers=True),
            _form("two_lags_kept", _lagging_on, HEATED, f"{_TWO}, P_1 and P_2 go {_KEPT}", remembers=True),
            _form(SETTLED[0], _reading_late, BALANCE, f"{_READS_RIGHT} lag of first order with tau_s, from D = 0"),
            _form(
                SETTLED[1],
                _reading_late,
                BALANCE,
                f"{_READS_RIGHT} lag: (1 - g) of first order with tau_s, g with tau_2, from D = 0",
            ),
            _form("two_lags", _lagging, HEATED, f"{_TWO}, P_1 = P_2 = P at the start of each recording"),
        )
    },
    variables=("transient",),
)
