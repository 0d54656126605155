"""Dependence of the offset on temperature beyond the quadratic."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Point, Symbol, Term, columns


def _scales(frame: Frame) -> tuple[Point, ...]:
    span = float(np.ptp(frame.temperature)) or 10.0
    return tuple((span * share,) for share in (0.08, 0.15, 0.25, 0.4, 0.7))


def _exponential(frame: Frame, point: Point) -> FloatArray:
    rise = np.exp(-(frame.temperature - 25.0) / point[0])
    return columns(rise, frame.last_direction * rise)


def _growing(frame: Frame, point: Point) -> FloatArray:
    rise = np.exp((frame.temperature - 45.0) / point[0])
    return columns(rise, frame.last_direction * rise)


def _cubic(frame: Frame, _: Point) -> FloatArray:
    x = (frame.temperature - 35.0) / 15.0
    return columns(x**3, frame.last_direction * x**3)


def _transitions(frame: Frame) -> tuple[Point, ...]:
    low, high = np.percentile(frame.temperature, [2, 98])
    span = float(high - low) or 10.0
    # the sharper a change, the closer its place has to be to be seen; the sharpest is a step, which stands in the gap
    # between two stages of a warm-up: a wider one moves the rows at both sides of it
    return tuple(
        (float(low + share * span), float(width * span))
        for width, number in ((0.005, 13), (0.05, 13), (0.12, 7), (0.3, 5))
        for share in np.linspace(0.1, 0.9, number)
    )


def _transition(frame: Frame, point: Point) -> FloatArray:
    step = np.tanh((frame.temperature - point[0]) / point[1])
    return columns(step, frame.last_direction * step)


def _knees(frame: Frame) -> tuple[Point, ...]:
    low, high = np.percentile(frame.temperature, [2, 98])
    span = float(high - low) or 10.0
    return tuple(
        (float(low + share * span), float(width * span))
        for width, number in ((0.02, 9), (0.1, 7))
        for share in np.linspace(0.1, 0.9, number)
    )


def _knee(frame: Frame, point: Point) -> FloatArray:
    x = (frame.temperature - point[0]) / point[1]
    # log(1 + exp(x)) that does not overflow
    beyond = point[1] * (np.maximum(x, 0.0) + np.log1p(np.exp(-np.abs(x))))
    return columns(beyond, frame.last_direction * beyond)


T_E = Symbol("t_e", "rad", "amplitude, the same in both directions")
T_O = Symbol("t_o", "rad", "amplitude, with the sign of the motion")
S_E = Symbol("s_e", "rad/K", "slope beyond the knee, the same in both directions")
S_O = Symbol("s_o", "rad/K", "slope beyond the knee, with the sign of the motion")
T_S = Symbol("T_s", "K", "temperature over which it falls by e", 0.0)
T_M = Symbol("T_m", "degC", "temperature of the change")
T_W = Symbol("T_w", "K", "temperature over which it changes", 0.0)

TERM = Term(
    effect="te.temperature_nonlinear",
    name="dependence of the transmission error on temperature beyond the quadratic",
    equation="TE += (t_e + d*t_o)*exp(-(T - 25 degC)/T_s), or growing, or cubic, a change at T_m over T_w, "
    "or a knee there",
    reference="viscosity laws, Vogel, Phys. Z. 22 (1921) 645",
    where="transmission_error's offset over temperature",
    forms={
        TRANSMISSION_ERROR: (
            Form(
                "exponential",
                _exponential,
                (T_E, T_O),
                (T_S,),
                _scales,
                equation="TE += (t_e + d*t_o)*exp(-(T - 25 degC)/T_s)",
            ),
            Form(
                "growing", _growing, (T_E, T_O), (T_S,), _scales, equation="TE += (t_e + d*t_o)*exp((T - 45 degC)/T_s)"
            ),
            Form("cubic", _cubic, (T_E, T_O), equation="TE += (t_e + d*t_o)*((T - 35 degC)/(15 K))**3"),
            Form(
                "transition",
                _transition,
                (T_E, T_O),
                (T_M, T_W),
                _transitions,
                equation="TE += (t_e + d*t_o)*tanh((T - T_m)/T_w)",
            ),
            Form(
                "knee",
                _knee,
                (S_E, S_O),
                (T_M, T_W),
                _knees,
                equation="TE += (s_e + d*s_o)*T_w*log(1 + exp((T - T_m)/T_w))",
            ),
        )
    },
    variables=("temperature",),
    shape={TRANSMISSION_ERROR: (("temperature", "p"), ("temperature", "n"))},
    any_function=True,
)
