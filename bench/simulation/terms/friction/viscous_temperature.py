"""Viscous friction whose viscosity falls exponentially with the lubricant's temperature."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns, logarithmic

REFERENCE = 100.0
"""speed of the motor, rad/s, at which a friction that is no straight line over the speed is as large as one that is"""


def _rates(_: Frame) -> tuple[Point, ...]:
    # oils and greases: 0.02 to 0.08 per kelvin at room temperature, more in the cold; the refinement may go half as far
    # again
    return logarithmic(0.012, 0.12, 10)


def _exponential(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.omega * np.exp(-point[0] * (frame.temperature - 25.0)))


def _vogel_factor(frame: Frame, beta: float) -> FloatArray:
    # exp(B/(T - T0)) relative to 25 degC, T0 = -60 degC: the slope at 25 degC is the parameter
    constant = beta * 85.0**2
    return np.asarray(np.exp(constant / (np.maximum(frame.temperature, -40.0) + 60.0) - constant / 85.0))


def _vogel(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.omega * _vogel_factor(frame, point[0]))


def _arrhenius(frame: Frame, point: Point) -> FloatArray:
    # exp(E/(R*T)) with the absolute temperature, relative to 25 degC
    constant = point[0] * 298.15**2
    return columns(frame.omega * np.exp(constant / (frame.temperature + 273.15) - constant / 298.15))


def _thinning_rates(_: Frame) -> tuple[Point, ...]:
    return tuple((rate, exponent) for (rate,) in logarithmic(0.012, 0.12, 6) for exponent in (0.6, 0.8))


def _thinning(frame: Frame, point: Point) -> FloatArray:
    speed = np.abs(frame.omega) / REFERENCE
    return columns(np.sign(frame.omega) * REFERENCE * speed ** point[1] * _vogel_factor(frame, point[0]))


F_E = Symbol("f_e", "N*m*s/rad", "viscous friction that follows the viscosity, at 25 degC", 0.0)
BETA = Symbol("beta", "1/K", "relative fall of the viscosity per kelvin at 25 degC", 0.0)
EXPONENT = Symbol(
    "n", "1", "exponent of the speed; below 1 in a bearing's film, or where a lubricant thins in shear", 0.5, 1.0
)

TERM = Term(
    effect="friction.viscous_temperature",
    name="viscosity falling exponentially with temperature",
    equation="tau_m += f_e * exp(-beta*(T - 25 degC)) * w_m",
    reference="Reynolds (1886); Vogel, Phys. Z. 22 (1921) 645; Bittencourt, Wernholt, ACC 2010; Palmgren, Ball and"
    " Roller Bearing Engineering (1959): a bearing's drag follows (viscosity*speed)**(2/3)",
    where="motor_torque at high speed, curved in temperature",
    forms={
        MOTOR_TORQUE: (
            Form("exponential", _exponential, (F_E,), (BETA,), _rates),
            Form(
                "arrhenius",
                _arrhenius,
                (F_E,),
                (BETA,),
                _rates,
                equation="tau_m += f_e*w_m*exp(beta*(298.15 K)**2*(1/(T + 273.15 K) - 1/(298.15 K)))",
            ),
            Form(
                "vogel",
                _vogel,
                (F_E,),
                (BETA,),
                _rates,
                equation="tau_m += f_e*w_m*exp(beta*(85 K)**2*(1/(max(T, -40 degC) + 60 K) - 1/(85 K)))",
            ),
            Form(
                "thinning",
                _thinning,
                (F_E,),
                (BETA, EXPONENT),
                _thinning_rates,
                equation="tau_m += f_e*w_m*(abs(w_m)/(100 rad/s))**(n - 1)"
                "*exp(beta*(85 K)**2*(1/(max(T, -40 degC) + 60 K) - 1/(85 K)))",
            ),
        )
    },
    variables=("temperature", "speed"),
    modifies=("friction.viscous",),
    shape={MOTOR_TORQUE: (("temperature", "w"),)},
)
