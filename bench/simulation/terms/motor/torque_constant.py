"""Gain error or saturation of the torque that the input drive reports."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns, top


def _gain(frame: Frame, _: Point) -> FloatArray:
    # the same course as that of a gain error of the torque sensor: where only the motor's torque tells, both are one
    return columns(frame.torque / frame.ratio)


def _drags(frame: Frame) -> tuple[Point, ...]:
    largest = top(frame.torque) / frame.ratio
    return tuple((share * largest,) for share in (0.03, 0.1, 0.25, 0.6))


def _shaft(frame: Frame, point: Point) -> FloatArray:
    """What the motor gives in steady motion: the load's part and the drag, which keeps the sign of the motion (n,)."""
    drag = point[0] if point else 0.0
    return np.asarray(frame.torque_level / frame.ratio + drag * frame.direction)


def _saturation(frame: Frame, point: Point) -> FloatArray:
    shaft = _shaft(frame, point)
    return columns(shaft, shaft * np.abs(shaft))


def _cubic(frame: Frame, point: Point) -> FloatArray:
    shaft = _shaft(frame, point)
    return columns(shaft, shaft**3)


G = Symbol("g", "1", "gain error of the reported torque", -0.5, 0.5)
S2 = Symbol("s_2", "1/(N*m)", "saturation, quadratic")
S3 = Symbol("s_3", "1/(N*m)^2", "saturation, cubic")
DRAG = Symbol("tau_d", "N*m", "drag at the motor's shaft, which the motor gives beside the load's torque", 0.0)

TERM = Term(
    effect="motor.torque_constant",
    name="gain error or saturation of the reported motor torque",
    equation="tau_m += g*x (+ s_2*x*abs(x) or s_3*x**3), x = tau/u + d*tau_d",
    reference="Krishnan, Permanent Magnet Synchronous and Brushless DC Motor Drives, CRC 2009, ch. 2",
    where="motor_torque in proportion to the load, without a trace in load_torque",
    forms={
        MOTOR_TORQUE: (
            Form("gain", _gain, (G,), equation="tau_m += g*tau/u"),
            Form(
                "saturation",
                _saturation,
                (G, S2),
                (DRAG,),
                _drags,
                equation="tau_m += g*x + s_2*x*abs(x), x = tau/u + d*tau_d",
            ),
            Form("cubic", _cubic, (G, S3), (DRAG,), _drags, equation="tau_m += g*x + s_3*x**3, x = tau/u + d*tau_d"),
        )
    },
    variables=("torque",),
    shape={MOTOR_TORQUE: (("torque", "1"),)},
)
