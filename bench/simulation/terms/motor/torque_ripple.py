"""Torque ripple of the input motor at orders 6k of its electrical period."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns


def _grid(_: Frame) -> tuple[Point, ...]:
    # six times the electrical order, for one to eight pole pairs
    return tuple((float(6 * k),) for k in range(1, 17))


def _ripple(frame: Frame, point: Point) -> FloatArray:
    angle = point[0] * frame.ratio * frame.theta
    return columns(np.cos(angle), np.sin(angle))


A_RC = Symbol("a_rc", "N*m", "cosine amplitude of the ripple")
A_RS = Symbol("a_rs", "N*m", "sine amplitude of the ripple")
ORDER = Symbol("n", "1", "order per motor revolution, 6k times the pole pairs", 0.0)

TERM = Term(
    effect="motor.torque_ripple",
    name="torque ripple of the input motor",
    equation="tau_m += a_rc*cos(n*u*theta) + a_rs*sin(n*u*theta), n = 6*k*p",
    reference="Jahns and Soong, IEEE Trans. Ind. Electron. 43 (1996) 321",
    where="motor_torque over the motor's angle",
    forms={MOTOR_TORQUE: (Form("ripple", _ripple, (A_RC, A_RS), (ORDER,), _grid),)},
    variables=("angle",),
)
