"""Viscous friction that differs by direction: seals, screws and gears that run easier one way."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns


def _speed(frame: Frame, _: Point) -> FloatArray:
    return columns(np.abs(frame.omega))


F_DV = Symbol("f_dv", "N*m*s/rad", "half of the difference between the viscous coefficients of the two directions")

TERM = Term(
    effect="friction.directional",
    name="viscous friction that differs by direction",
    equation="tau_m += f_dv * abs(w_m)",
    reference="Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994) 1083, sec. 2.1",
    where="motor_torque: drag grows with speed more in one direction than in the other",
    forms={MOTOR_TORQUE: (Form("viscous", _speed, (F_DV,)),)},
    variables=("velocity",),
    modifies=("friction.coulomb", "friction.viscous"),
    shape={MOTOR_TORQUE: (("velocity", "1"),)},
)
