"""Nominal terms of the load side (equation 4 of the bench)."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import LOAD_TORQUE, Form, Point, Symbol, Term, columns

REFERENCE = "load side of the nominal simulation"


def _reaction(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.load_motor_torque)


def _bearing(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.direction)


def _inertia(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.load_acceleration)


def _offset(frame: Frame, _: Point) -> FloatArray:
    return columns(np.ones(frame.size))


REACTION = Term(
    effect="load.reaction",
    name="torque of the load motor",
    equation="load_torque += k*load_motor_torque",
    reference=REFERENCE,
    where="load_torque in proportion to the load motor's",
    forms={LOAD_TORQUE: (Form("nominal", _reaction, (Symbol("k", "1", "share, 1 by equilibrium"),)),)},
    nominal=True,
    variables=("torque",),
)
BEARING = Term(
    effect="load.bearing_friction",
    name="friction of the load-side bearings",
    equation="load_torque += d*f_b",
    reference=REFERENCE,
    where="load_torque, sign of the motion",
    forms={LOAD_TORQUE: (Form("nominal", _bearing, (Symbol("f_b", "N*m", "bearing friction", 0.0),)),)},
    nominal=True,
    variables=("direction",),
)
INERTIA = Term(
    effect="load.inertia",
    name="inertia of the load side",
    equation="load_torque += J_L*d2q/dt2",
    reference=REFERENCE,
    where="load_torque while speeding up or slowing down",
    forms={LOAD_TORQUE: (Form("nominal", _inertia, (Symbol("J_L", "kg*m^2", "inertia of the load side", 0.0),)),)},
    nominal=True,
    variables=("acceleration",),
)
OFFSET = Term(
    effect="load.torque_offset",
    name="constant zero of the load torque",
    equation="load_torque += z_0",
    reference=REFERENCE,
    where="load_torque everywhere",
    forms={LOAD_TORQUE: (Form("nominal", _offset, (Symbol("z_0", "N*m", "zero"),)),)},
    nominal=True,
    variables=("direction",),
)
TERMS = (REACTION, BEARING, INERTIA, OFFSET)
