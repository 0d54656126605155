"""Curvature of the torque sensor, or saturation of the load motor: in load_torque, with a trace in motor_torque."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import LOAD_TORQUE, MOTOR_TORQUE, Form, Point, Symbol, Term, columns, top


def _forms(
    x: Callable[[Frame], FloatArray],
    largest: Callable[[Frame], float],
    share: Callable[[Frame], float],
    shown: Callable[[str], str],
) -> tuple[Form, ...]:
    """Curves of the load ``x`` in kN*m (n,), ``largest`` N*m, times the ``share`` of them that the channel shows;
    ``shown``: the channel's equation with a curve of x.
    """

    def _square(frame: Frame, _: Point) -> FloatArray:
        return columns(share(frame) * x(frame) ** 2)

    def _odd_square(frame: Frame, _: Point) -> FloatArray:
        return columns(share(frame) * x(frame), share(frame) * x(frame) * np.abs(x(frame)))

    def _cubic(frame: Frame, _: Point) -> FloatArray:
        return columns(share(frame) * x(frame), share(frame) * x(frame) ** 3)

    def _full(frame: Frame, _: Point) -> FloatArray:
        return columns(share(frame) * x(frame), share(frame) * x(frame) ** 2, share(frame) * x(frame) ** 3)

    def _odd_square_alone(frame: Frame, _: Point) -> FloatArray:
        return columns(share(frame) * x(frame) * np.abs(x(frame)))

    def _cubic_alone(frame: Frame, _: Point) -> FloatArray:
        return columns(share(frame) * x(frame) ** 3)

    def _knees(frame: Frame) -> tuple[Point, ...]:
        return tuple((part * largest(frame),) for part in (0.45, 0.6, 0.75, 0.9))

    def _knee(frame: Frame, point: Point) -> FloatArray:
        beyond = np.maximum(np.abs(x(frame)) - point[0] / 1000.0, 0.0)
        return columns(share(frame) * np.sign(x(frame)) * beyond)

    return (
        Form("square", _square, (C_2,), equation=shown("c_2*x**2")),
        Form("odd_square", _odd_square, (C_1, C_2O), equation=shown("c_1*x + c_2o*x*abs(x)")),
        Form("cubic", _cubic, (C_1, C_3), equation=shown("c_1*x + c_3*x**3")),
        Form("odd_square_alone", _odd_square_alone, (C_2O,), equation=shown("c_2o*x*abs(x)")),
        Form("cubic_alone", _cubic_alone, (C_3,), equation=shown("c_3*x**3")),
        Form("full", _full, (C_1, C_2, C_3), equation=shown("c_1*x + c_2*x**2 + c_3*x**3")),
        Form(
            "knee",
            _knee,
            (SLOPE,),
            (KNEE,),
            _knees,
            equation=shown("c_k*sgn(x)*max(abs(x) - tau_k/(1 kN*m), 0)"),
        ),
    )


C_1 = Symbol("c_1", "N*m", "proportional part at 1 kN*m")
C_2 = Symbol("c_2", "N*m", "quadratic part at 1 kN*m")
C_2O = Symbol("c_2o", "N*m", "odd quadratic part at 1 kN*m")
C_3 = Symbol("c_3", "N*m", "cubic part at 1 kN*m")
KNEE = Symbol("tau_k", "N*m", "torque at which saturation begins", 0.0)
SLOPE = Symbol("c_k", "N*m", "loss per kN*m beyond the knee")

TERM = Term(
    effect="sensor.torque_nonlinearity",
    name="curvature of the torque sensor or saturation of the load motor",
    equation="load_torque += c_2*x**2 + c_3*x**3, x = load_motor_torque/(1 kN*m); or a knee; tau_m less that over u",
    reference="VDI/VDE 2646; data sheets' linearity deviation",
    where="load_torque, curved in the load, with the opposite trace in motor_torque",
    forms={
        LOAD_TORQUE: _forms(
            lambda frame: frame.load_motor_level / 1000.0,
            lambda frame: top(frame.load_motor_torque),
            lambda _: 1.0,
            lambda curve: f"load_torque += {curve}, x = load_motor_torque/(1 kN*m)",
        ),
        # what the sensor reads too much the motor does not give: seen where nothing else says what the load is
        MOTOR_TORQUE: _forms(
            lambda frame: frame.torque_level / 1000.0,
            lambda frame: top(frame.torque),
            lambda frame: -1.0 / frame.ratio,
            lambda curve: f"tau_m -= ({curve})/u, x = tau/(1 kN*m)",
        ),
    },
    variables=("torque",),
    shape={LOAD_TORQUE: (("load_motor_torque", "1"),)},
    # the friction of the load passes the sensor, too: its curvature makes a part of it that goes with the direction
    passing={LOAD_TORQUE: (("load_motor_torque", "d"),)},
)
