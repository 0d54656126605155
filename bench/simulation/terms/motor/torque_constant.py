"""Gain error or saturation of the torque that the input drive reports."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns


def _gain(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.torque_level / frame.ratio)


def _saturation(frame: Frame, _: Point) -> FloatArray:
    shaft = frame.torque_level / frame.ratio
    return columns(shaft, shaft * np.abs(shaft))


def _cubic(frame: Frame, _: Point) -> FloatArray:
    shaft = frame.torque_level / frame.ratio
    return columns(shaft, shaft**3)


G = Symbol("g", "1", "gain error of the reported torque", -0.5, 0.5)
S2 = Symbol("s_2", "1/(N*m)", "saturation, quadratic")
S3 = Symbol("s_3", "1/(N*m)^2", "saturation, cubic")

TERM = Term(
    effect="motor.torque_constant",
    name="gain error or saturation of the reported motor torque",
    equation="tau_m += g*tau/u (+ s_2*(tau/u)*abs(tau/u) or s_3*(tau/u)**3)",
    reference="Krishnan, Permanent Magnet Synchronous and Brushless DC Motor Drives, CRC 2009, ch. 2",
    where="motor_torque in proportion to the load, without a trace in load_torque",
    forms={
        MOTOR_TORQUE: (
            Form("gain", _gain, (G,)),
            Form("saturation", _saturation, (G, S2)),
            Form("cubic", _cubic, (G, S3)),
        )
    },
    variables=("torque",),
    shape={MOTOR_TORQUE: (("torque", "1"),)},
)
