"""Friction modulated with the output angle."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns

_ORDERS = range(1, 13)
"""orders that rows of a sixth of a radian show; higher ones come from the order spectrum"""


def _grid(frame: Frame) -> tuple[Point, ...]:
    # a wave of which no whole period was run is no modulation; the table over the angle has what is there
    travelled = float(np.ptp(frame.q)) if frame.size else 0.0
    return tuple((float(order),) for order in _ORDERS if order * travelled >= 2.0 * np.pi)


def _modulated(frame: Frame, point: Point) -> FloatArray:
    angle = point[0] * frame.q
    return columns(frame.direction * np.cos(angle), frame.direction * np.sin(angle))


def _loaded(frame: Frame, point: Point) -> FloatArray:
    angle = point[0] * frame.q
    load = np.abs(frame.torque) / 1000.0
    return columns(frame.direction * load * np.cos(angle), frame.direction * load * np.sin(angle))


F_PC = Symbol("f_pc", "N*m", "cosine amplitude of the friction over the output angle")
F_PS = Symbol("f_ps", "N*m", "sine amplitude of the friction over the output angle")
F_PLC = Symbol("f_plc", "N*m", "cosine amplitude of the friction over the output angle at a load of 1 kN*m")
F_PLS = Symbol("f_pls", "N*m", "sine amplitude of the friction over the output angle at a load of 1 kN*m")
ORDER = Symbol("m", "1", "order per output revolution", 0.0)

TERM = Term(
    effect="friction.position_dependent",
    name="friction modulated with the output angle",
    equation="tau_m += d * (f_pc*cos(m*q) + f_ps*sin(m*q)); with f_plc, f_pls times |tau|/(1 kN*m)",
    reference="Armstrong-Helouvry, Control of Machines with Friction, Kluwer 1991, ch. 4",
    where="motor_torque over the output angle, changing sign with the direction",
    forms={
        MOTOR_TORQUE: (
            Form(
                "constant",
                _modulated,
                (F_PC, F_PS),
                (ORDER,),
                _grid,
                equation="tau_m += d*(f_pc*cos(m*q) + f_ps*sin(m*q))",
            ),
            Form(
                "with_load",
                _loaded,
                (F_PLC, F_PLS),
                (ORDER,),
                _grid,
                equation="tau_m += d*abs(tau)/(1 kN*m)*(f_plc*cos(m*q) + f_pls*sin(m*q))",
            ),
        )
    },
    variables=("angle",),
    modifies=("friction.coulomb",),
    shape={MOTOR_TORQUE: (("angle", "d"),)},
    any_function=True,
)
