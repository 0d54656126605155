"""Nominal terms of the input motor (input torque balance, equation 2 of the bench)."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns
from bench.simulation.terms.nominal.friction import REFERENCE


def _reaction(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.torque / frame.ratio)


def _inertia(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.acceleration)


def _offset(frame: Frame, _: Point) -> FloatArray:
    return columns(np.ones(frame.size))


LOAD_REACTION = Term(
    effect="motor.load_reaction",
    name="reaction of the load torque",
    equation="tau_m += k*tau/u",
    reference=REFERENCE,
    where="motor_torque in proportion to the load",
    forms={MOTOR_TORQUE: (Form("nominal", _reaction, (Symbol("k", "1", "share of tau/u, 1 by geometry"),)),)},
    nominal=True,
    variables=("torque",),
)
INERTIA = Term(
    effect="motor.inertia",
    name="inertia of the input side",
    equation="tau_m += J*dw_m/dt",
    reference=REFERENCE,
    where="motor_torque while speeding up or slowing down",
    forms={MOTOR_TORQUE: (Form("nominal", _inertia, (Symbol("J", "kg*m^2", "inertia at the motor shaft", 0.0),)),)},
    nominal=True,
    variables=("acceleration",),
)
OFFSET = Term(
    effect="motor.torque_offset",
    name="constant offset of the motor torque",
    equation="tau_m += tau_0",
    reference=REFERENCE,
    where="motor_torque everywhere",
    forms={MOTOR_TORQUE: (Form("nominal", _offset, (Symbol("tau_0", "N*m", "offset"),)),)},
    nominal=True,
    variables=("direction",),
)
TERMS = (LOAD_REACTION, INERTIA, OFFSET)
