"""Gain error or saturation of the torque that the input drive reports."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns, top


def _gain(frame: Frame, _: Point) -> FloatArray:
    # the same course as that of a gain error of the torque sensor: where only the motor's torque tells, both are one
    return columns(frame.torque / frame.ratio)


def _warming(frame: Frame, _: Point) -> FloatArray:
    load = frame.torque / frame.ratio
    return columns(load, load * (frame.temperature - 25.0))


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


def _limits(frame: Frame) -> tuple[Point, ...]:
    largest = top(frame.torque) / frame.ratio
    fastest = max(top(frame.omega), 1e-12)
    drags = ((0.05, 0.02), (0.3, 0.02), (0.1, 0.2))
    return tuple(
        (limit * largest, sharpness, drag * largest, viscous * largest / fastest)
        for limit in (0.6, 1.2, 2.4)
        for sharpness in (2.0, 6.0)
        for drag, viscous in drags
    )


def _limited(frame: Frame, point: Point) -> FloatArray:
    limit, sharpness, drag, viscous = point
    shaft = _shaft(frame, (drag,)) + viscous * frame.omega
    held = shaft / (1.0 + np.abs(shaft / limit) ** sharpness) ** (1.0 / sharpness)
    return columns(frame.torque_level / frame.ratio, held - shaft)


MOST = 4.0
"""largest gain error that is possible; with it a limit takes 1 + g of the torque beyond it"""
G = Symbol("g", "1", "gain error of the reported torque", -0.9, MOST)
G_T = Symbol("g_T", "1/K", "change of the gain per kelvin: magnets weaken as they warm")
S2 = Symbol("s_2", "1/(N*m)", "saturation, quadratic")
S3 = Symbol("s_3", "1/(N*m)^2", "saturation, cubic")
LIMITED = Symbol("s", "1", "how much of what a limit takes is taken", 0.0, 1.0 + MOST)
LIMIT = Symbol("tau_s", "N*m", "largest torque that is reported", 0.0)
SHARPNESS = Symbol("p", "1", "sharpness of the limit: 1 bends all the way, 10 is a corner", 1.0, 20.0)
DRAG = Symbol("tau_d", "N*m", "drag at the motor's shaft, which the motor gives beside the load's torque", 0.0)
VISCOUS = Symbol("v_d", "N*m*s/rad", "the same, in proportion to the speed", 0.0)

TERM = Term(
    effect="motor.torque_constant",
    name="gain error or saturation of the reported motor torque",
    equation="tau_m += g*x (+ g_T*(T - 25 degC)*x, s_2*x*abs(x), s_3*x**3, or what a limit takes), x = tau/u + d*tau_d",
    reference="Krishnan, Permanent Magnet Synchronous and Brushless DC Motor Drives, CRC 2009, ch. 2",
    where="motor_torque in proportion to the load, without a trace in load_torque",
    forms={
        MOTOR_TORQUE: (
            Form("gain", _gain, (G,), equation="tau_m += g*tau/u"),
            Form(
                "temperature",
                _warming,
                (G, G_T),
                shape=(("temperature", "tau"),),
                equation="tau_m += (g + g_T*(T - 25 degC))*tau/u",
                variables=("torque", "temperature"),
            ),
            Form(
                "saturation",
                _saturation,
                (G, S2),
                (DRAG,),
                _drags,
                equation="tau_m += g*x + s_2*x*abs(x), x = tau/u + d*tau_d",
            ),
            Form("cubic", _cubic, (G, S3), (DRAG,), _drags, equation="tau_m += g*x + s_3*x**3, x = tau/u + d*tau_d"),
            Form(
                "limit",
                _limited,
                (G, LIMITED),
                (LIMIT, SHARPNESS, DRAG, VISCOUS),
                _limits,
                equation="tau_m += g*tau/u + s*(x/(1 + abs(x/tau_s)**p)**(1/p) - x), x = tau/u + d*tau_d + v_d*w_m",
            ),
        )
    },
    variables=("torque",),
    shape={MOTOR_TORQUE: (("torque", "1"),)},
)
