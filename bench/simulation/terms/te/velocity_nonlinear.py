"""Lubricant-film like dependence of the offset on the speed, beyond the quadratic."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Point, Symbol, Term, columns, logarithmic, top

THICKNESS = 0.68
"""power of the speed with which a film between loaded curved surfaces grows (Hamrock and Dowson, 1977)"""

STEEPER = (1.5, 2.2)
"""powers from which a film that builds up faster than in proportion to the speed is refined"""


def _scales(frame: Frame) -> tuple[Point, ...]:
    fastest = top(frame.velocity)
    return logarithmic(0.03 * fastest, 0.6 * fastest, 9)


def _exponential(frame: Frame, point: Point) -> FloatArray:
    film = np.exp(-np.abs(frame.velocity) / point[0])
    return columns(film, frame.last_direction * film)


def _of_a_power(frame: Frame, point: Point) -> FloatArray:
    speed, power = point
    film = 1.0 / (1.0 + (np.abs(frame.velocity) / speed) ** power)
    return columns(film, frame.last_direction * film)


def _rational(frame: Frame, point: Point) -> FloatArray:
    return _of_a_power(frame, (*point, 1.0))


def _elastohydrodynamic(frame: Frame, point: Point) -> FloatArray:
    return _of_a_power(frame, (*point, THICKNESS))


def _speeds_and_powers(frame: Frame) -> tuple[Point, ...]:
    return tuple((*speed, power) for speed in _scales(frame) for power in STEEPER)


def _saturating(frame: Frame, point: Point) -> FloatArray:
    film = np.exp(-((frame.velocity / point[0]) ** 2))
    return columns(film, frame.last_direction * film)


V_E = Symbol("v_e", "rad", "offset at standstill, the same in both directions")
V_O = Symbol("v_o", "rad", "offset at standstill, with the sign of the motion")
V_S = Symbol("v_s", "rad/s", "speed over which the film builds up", 0.0)
N = Symbol("n", "1", "power of the speed with which it does", 1.0, 3.3)

TERM = Term(
    effect="te.velocity_nonlinear",
    name="film-like dependence of the transmission error on speed",
    equation="TE += (v_e + d*v_o)*exp(-abs(dtheta)/v_s)",
    reference="Hamrock, Fundamentals of Fluid Film Lubrication (2004)",
    where="transmission_error at low speed",
    forms={
        TRANSMISSION_ERROR: (
            Form("exponential", _exponential, (V_E, V_O), (V_S,), _scales),
            Form(
                "rational", _rational, (V_E, V_O), (V_S,), _scales, equation="TE += (v_e + d*v_o)/(1 + abs(dtheta)/v_s)"
            ),
            Form(
                "elastohydrodynamic",
                _elastohydrodynamic,
                (V_E, V_O),
                (V_S,),
                _scales,
                equation=f"TE += (v_e + d*v_o)/(1 + (abs(dtheta)/v_s)**{THICKNESS:g})",
            ),
            Form(
                "power",
                _of_a_power,
                (V_E, V_O),
                (V_S, N),
                _speeds_and_powers,
                equation="TE += (v_e + d*v_o)/(1 + (abs(dtheta)/v_s)**n)",
            ),
            Form(
                "gaussian",
                _saturating,
                (V_E, V_O),
                (V_S,),
                _scales,
                equation="TE += (v_e + d*v_o)*exp(-(dtheta/v_s)**2)",
            ),
        )
    },
    variables=("speed",),
    shape={TRANSMISSION_ERROR: (("speed", "p"), ("speed", "n"))},
    any_function=True,
)
