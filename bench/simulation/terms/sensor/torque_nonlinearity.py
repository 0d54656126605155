"""Curvature of the torque sensor, or saturation of the load motor."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import LOAD_TORQUE, Form, Point, Symbol, Term, columns, top


def _load(frame: Frame) -> FloatArray:
    return frame.load_motor_level


def _square(frame: Frame, _: Point) -> FloatArray:
    x = _load(frame) / 1000.0
    return columns(x**2)


def _odd_square(frame: Frame, _: Point) -> FloatArray:
    x = _load(frame) / 1000.0
    return columns(x, x * np.abs(x))


def _cubic(frame: Frame, _: Point) -> FloatArray:
    x = _load(frame) / 1000.0
    return columns(x, x**3)


def _full(frame: Frame, _: Point) -> FloatArray:
    x = _load(frame) / 1000.0
    return columns(x, x**2, x**3)


def _odd_square_alone(frame: Frame, _: Point) -> FloatArray:
    x = _load(frame) / 1000.0
    return columns(x * np.abs(x))


def _cubic_alone(frame: Frame, _: Point) -> FloatArray:
    return columns((_load(frame) / 1000.0) ** 3)


def _knees(frame: Frame) -> tuple[Point, ...]:
    largest = top(frame.load_motor_torque)
    return tuple((share * largest,) for share in (0.45, 0.6, 0.75, 0.9))


def _knee(frame: Frame, point: Point) -> FloatArray:
    x = _load(frame)
    return columns(np.sign(x) * np.maximum(np.abs(x) - point[0], 0.0) / 1000.0)


C_1 = Symbol("c_1", "N*m", "proportional part at 1 kN*m")
C_2 = Symbol("c_2", "N*m", "quadratic part at 1 kN*m")
C_2O = Symbol("c_2o", "N*m", "odd quadratic part at 1 kN*m")
C_3 = Symbol("c_3", "N*m", "cubic part at 1 kN*m")
KNEE = Symbol("tau_k", "N*m", "torque at which saturation begins", 0.0)
SLOPE = Symbol("c_k", "N*m", "loss per kN*m beyond the knee")

TERM = Term(
    effect="sensor.torque_nonlinearity",
    name="curvature of the torque sensor or saturation of the load motor",
    equation="load_torque += c_2*x**2 + c_3*x**3, x = load_motor_torque/(1 kN*m); or a knee",
    reference="VDI/VDE 2646; data sheets' linearity deviation",
    where="load_torque, curved in the load",
    forms={
        LOAD_TORQUE: (
            Form("square", _square, (C_2,)),
            Form("odd_square", _odd_square, (C_1, C_2O)),
            Form("cubic", _cubic, (C_1, C_3)),
            Form("odd_square_alone", _odd_square_alone, (C_2O,)),
            Form("cubic_alone", _cubic_alone, (C_3,)),
            Form("full", _full, (C_1, C_2, C_3)),
            Form("knee", _knee, (SLOPE,), (KNEE,), _knees),
        )
    },
    variables=("torque",),
    shape={LOAD_TORQUE: (("load_motor_torque", "1"),)},
    # the friction of the load passes the sensor, too: its curvature makes a part of it that goes with the direction
    passing={LOAD_TORQUE: (("load_motor_torque", "d"),)},
)
