"""Churning: drag that grows with the square of the speed."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns


def _square(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.omega * np.abs(frame.omega))


def _powers(_: Frame) -> tuple[Point, ...]:
    return ((1.6,), (1.8,), (2.3,), (2.6,), (3.0,))


def _power(frame: Frame, point: Point) -> FloatArray:
    speed = np.abs(frame.omega)
    return columns(np.sign(frame.omega) * speed ** point[0] / 10.0 ** (point[0] - 2.0))


F_Q = Symbol("f_q", "N*m*s^2/rad^2", "churning coefficient; below 0 where the oil thins in shear")
EXPONENT = Symbol("n", "1", "exponent of the speed", 1.2, 4.0)

TERM = Term(
    effect="friction.viscous_quadratic",
    name="churning, quadratic in speed",
    equation="tau_m += f_q * w_m * abs(w_m)",
    reference="Terekhov (1975); Changenet and Velex, J. Mech. Des. 129 (2007) 128",
    where="motor_torque at high speed",
    forms={
        MOTOR_TORQUE: (
            Form("square", _square, (F_Q,)),
            Form(
                "power",
                _power,
                (F_Q,),
                (EXPONENT,),
                _powers,
                equation="tau_m += f_q*sgn(w_m)*abs(w_m)**n/(10 rad/s)**(n - 2)",
            ),
        )
    },
    variables=("speed",),
    modifies=("friction.coulomb", "friction.viscous"),
    shape={MOTOR_TORQUE: (("speed", "d"),)},
)
