"""Lost motion or backlash: a saturating step of the offset about zero torque."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import (
    TRANSMISSION_ERROR,
    Columns,
    Form,
    Point,
    Symbol,
    Term,
    columns,
    logarithmic,
    top,
)


def _scales(frame: Frame) -> tuple[Point, ...]:
    largest = top(frame.torque)
    # a range may be left by half: what is passed beyond a fifth of the largest torque is stiffness, not lost motion
    return logarithmic(0.01 * largest, 0.133 * largest, 9)


def _tanh(frame: Frame, point: Point) -> FloatArray:
    return columns(-np.tanh(frame.torque_level / point[0]))


def _arctan(frame: Frame, point: Point) -> FloatArray:
    return columns(-2.0 / np.pi * np.arctan(frame.torque_level / point[0]))


def _algebraic(frame: Frame, point: Point) -> FloatArray:
    return columns(-frame.torque_level / np.sqrt(frame.torque_level**2 + point[0] ** 2))


def _piecewise(frame: Frame, point: Point) -> FloatArray:
    return columns(-np.clip(frame.torque_level / (1.5 * point[0]), -1.0, 1.0))


def _off_centre(frame: Frame) -> tuple[Point, ...]:
    return tuple((width, share * width) for (width,) in _scales(frame)[::2] for share in OFF)


def _by_direction(frame: Frame, point: Point) -> FloatArray:
    passed = np.tanh((frame.torque_level - point[1]) / point[0])
    return columns(-passed, -frame.last_direction * passed)


def _passed_off_centre(passed: Callable[[FloatArray], FloatArray]) -> Columns:
    """Lost motion that is ``passed`` about a torque other than zero, in one of the courses that it has about zero."""
    return lambda frame, point: columns(-passed((frame.torque_level - point[1]) / point[0]))


OFF = (-0.6, 0.6)
"""of the torque within which lost motion is passed, by which its middle is off zero torque where it is refined from: a
sensor's zero, or the drag of the output's bearing
"""
J = Symbol("j_2", "rad", "half of the lost motion, by the sign of the torque")
J_D = Symbol(
    "j_d",
    "rad",
    "by how much half of the lost motion is larger than j_2 in positive direction, and smaller in negative",
)
TAU_0 = Symbol("tau_0", "N*m", "torque about which it is passed")
TAU_J = Symbol("tau_j", "N*m", "torque within which it is passed", 0.0)

_OFF_CENTRE: tuple[tuple[str, Callable[[FloatArray], FloatArray], str], ...] = (
    ("tanh", np.tanh, "TE -= j_2*tanh((tau - tau_0)/tau_j)"),
    ("arctan", lambda x: 2.0 / np.pi * np.arctan(x), "TE -= j_2*2/pi*arctan((tau - tau_0)/tau_j)"),
    ("algebraic", lambda x: x / np.sqrt(x**2 + 1.0), "TE -= j_2*x/sqrt(x**2 + 1), x = (tau - tau_0)/tau_j"),
)
"""courses that a lost motion may have about a torque other than zero: name, of what, equation"""

TERM = Term(
    effect="te.lost_motion",
    name="lost motion",
    equation="TE -= j_2*tanh(tau/tau_j)",
    reference="VDI 2060/ISO: lost motion at 3 % of rated torque; Mesmer et al., IEEE AIM 2022",
    where="transmission_error's offset about zero torque",
    forms={
        TRANSMISSION_ERROR: (
            Form("tanh", _tanh, (J,), (TAU_J,), _scales),
            Form("arctan", _arctan, (J,), (TAU_J,), _scales, equation="TE -= j_2*2/pi*arctan(tau/tau_j)"),
            Form("algebraic", _algebraic, (J,), (TAU_J,), _scales, equation="TE -= j_2*tau/sqrt(tau**2 + tau_j**2)"),
            Form(
                "piecewise", _piecewise, (J,), (TAU_J,), _scales, equation="TE -= j_2*max(-1, min(1, tau/(1.5*tau_j)))"
            ),
            *(
                Form(f"{name} off centre", _passed_off_centre(passed), (J,), (TAU_J, TAU_0), _off_centre, equation=text)
                for name, passed, text in _OFF_CENTRE
            ),
            Form(
                "by direction",
                _by_direction,
                (J, J_D),
                (TAU_J, TAU_0),
                _off_centre,
                equation="TE -= (j_2 + d*j_d)*tanh((tau - tau_0)/tau_j)",
            ),
        )
    },
    variables=("torque",),
    shape={TRANSMISSION_ERROR: (("torque", "1"),)},
)
