"""Stribeck friction: extra friction near standstill that decays with speed."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns, logarithmic, slow_speed, top

SEEN = 3.0
"""Stribeck speeds at the slowest speed that was measured: of what is less than a twentieth there nothing is seen"""

RATES = (-0.06, -0.02, 0.02, 0.06)
"""1/K by which viscosities of oils and greases fall; a film that breaks down as it warms goes the other way"""
EXPONENTS = (0.8, 1.7)
"""to begin with, between the curves of Bo and Pavelescu (0.5 to 1), Tustin (1) and Gauss (2)"""


def _grid(frame: Frame) -> tuple[Point, ...]:
    moving = frame.direction != 0
    fastest, slowest = top(frame.omega), slow_speed(frame.omega)
    if moving.any():
        slowest = max(slowest, float(np.percentile(np.abs(frame.omega[moving]), 1.0)) / SEEN)
    return logarithmic(slowest, min(0.5 * fastest, 40.0 * slowest), 12)


def _hersey_grid(frame: Frame) -> tuple[Point, ...]:
    # each speed is that at the temperature in the middle: at 25 degC, where nobody may have been, it is another
    rise = float(np.median(frame.temperature)) - 25.0
    return tuple(
        (speed * float(np.exp(-rate * rise)), rate, exponent)
        for (speed,) in _grid(frame)[::2]
        for rate in RATES
        for exponent in EXPONENTS
    )


def _hersey(frame: Frame, point: Point) -> FloatArray:
    speed = np.abs(frame.omega) * np.exp(-point[1] * (frame.temperature - 25.0)) / point[0]
    return columns(frame.direction * np.exp(-(speed ** point[2])))


def _gaussian(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.direction * np.exp(-((np.abs(frame.omega) / point[0]) ** 2)))


def _exponential(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.direction * np.exp(-np.abs(frame.omega) / point[0]))


def _rational(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.direction / (1.0 + (np.abs(frame.omega) / point[0]) ** 2))


def _slow_rational(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.direction / (1.0 + np.abs(frame.omega) / point[0]))


F_S = Symbol("f_s", "N*m", "extra friction at standstill", 0.0)
W_S = Symbol("w_s", "rad/s", "Stribeck speed of the motor shaft", 0.0)
BETA = Symbol("beta", "1/K", "relative rise of the Stribeck speed per kelvin, that of the lubricant's fluidity")
DELTA = Symbol("delta", "1", "exponent of the curve", 0.4, 2.5)

TERM = Term(
    effect="friction.stribeck",
    name="Stribeck friction",
    equation=(
        "tau_m += d * f_s * exp(-(abs(w_m)/w_s)**delta), delta 2 (Gaussian) or 1; or d * f_s / (1 + (abs(w_m)/w_s)**2);"
        " or w_s that follows the temperature, w_s*exp(beta*(T - 25 degC))"
    ),
    reference=(
        "Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083; Bo and Pavelescu, Wear 82 (1982) 277;"
        " Hersey, J. Wash. Acad. Sci. 4 (1914) 542: the regime of a film follows viscosity*speed"
    ),
    where="motor_torque at low speed, sign of the motion",
    forms={
        MOTOR_TORQUE: (
            Form("exponential", _exponential, (F_S,), (W_S,), _grid, equation="tau_m += d*f_s*exp(-abs(w_m)/w_s)"),
            Form("gaussian", _gaussian, (F_S,), (W_S,), _grid, equation="tau_m += d*f_s*exp(-(abs(w_m)/w_s)**2)"),
            Form("rational", _rational, (F_S,), (W_S,), _grid, equation="tau_m += d*f_s/(1 + (abs(w_m)/w_s)**2)"),
            Form("slow_rational", _slow_rational, (F_S,), (W_S,), _grid, equation="tau_m += d*f_s/(1 + abs(w_m)/w_s)"),
            Form(
                "hersey",
                _hersey,
                (F_S,),
                (W_S, BETA, DELTA),
                _hersey_grid,
                equation="tau_m += d*f_s*exp(-(abs(w_m)*exp(-beta*(T - 25 degC))/w_s)**delta)",
                variables=("speed", "temperature"),
            ),
        )
    },
    variables=("speed",),
    modifies=("friction.coulomb",),
    shape={MOTOR_TORQUE: (("speed", "d"),)},
)
