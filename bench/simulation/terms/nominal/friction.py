"""Nominal friction of the input side (input torque balance, equation 2 of the bench)."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns

REFERENCE = "input torque balance of the nominal simulation"


def _coulomb(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.direction)


def _viscous(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.omega)


def _viscous_temperature(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.omega * (frame.temperature - 25.0))


def _load_dependent(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.direction * np.abs(frame.torque) / frame.ratio)


COULOMB = Term(
    effect="friction.coulomb",
    name="Coulomb friction",
    equation="tau_m += d*f_c",
    reference=REFERENCE,
    where="motor_torque, sign of the motion",
    forms={MOTOR_TORQUE: (Form("nominal", _coulomb, (Symbol("f_c", "N*m", "Coulomb friction", 0.0),)),)},
    nominal=True,
    variables=("direction",),
)
VISCOUS = Term(
    effect="friction.viscous",
    name="viscous friction",
    equation="tau_m += f_v*w_m",
    reference=REFERENCE,
    where="motor_torque in proportion to speed",
    forms={MOTOR_TORQUE: (Form("nominal", _viscous, (Symbol("f_v", "N*m*s/rad", "viscous friction", 0.0),)),)},
    nominal=True,
    variables=("speed",),
)
VISCOUS_TEMPERATURE = Term(
    effect="friction.viscous_temperature_linear",
    name="viscous friction falling in proportion to temperature",
    equation="tau_m += f_vT*w_m*(T - 25 degC)",
    reference=REFERENCE,
    where="motor_torque at speed, by temperature",
    forms={
        MOTOR_TORQUE: (Form("nominal", _viscous_temperature, (Symbol("f_vT", "N*m*s/(rad*K)", "change per kelvin"),)),)
    },
    nominal=True,
    variables=("temperature", "speed"),
    modifies=("friction.viscous",),
)
LOAD_DEPENDENT = Term(
    effect="friction.load_dependent",
    name="load-dependent friction",
    equation="tau_m += d*f_l*abs(tau)/u",
    reference=REFERENCE,
    where="motor_torque under load, sign of the motion",
    forms={MOTOR_TORQUE: (Form("nominal", _load_dependent, (Symbol("f_l", "1", "load-dependent friction", 0.0),)),)},
    nominal=True,
    variables=("torque",),
)
TERMS = (COULOMB, VISCOUS, VISCOUS_TEMPERATURE, LOAD_DEPENDENT)
