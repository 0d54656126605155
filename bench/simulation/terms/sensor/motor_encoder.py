"""Eccentricity or interpolation error of the motor encoder: orders k·u, the same at any load, speed and temperature."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Point, Symbol, Term, columns


def _grid(_: Frame) -> tuple[Point, ...]:
    return tuple((float(k),) for k in (1, 2, 3, 4, 6, 8))


def _eccentric(frame: Frame, point: Point) -> FloatArray:
    angle = point[0] * frame.ratio * frame.theta
    return columns(np.cos(angle), np.sin(angle))


E_C = Symbol("e_c", "rad", "cosine amplitude at the output")
E_S = Symbol("e_s", "rad", "sine amplitude at the output")
ORDER = Symbol("k", "1", "order per motor revolution", 0.0)

TERM = Term(
    effect="sensor.motor_encoder",
    name="error of the motor encoder",
    equation="TE += e_c*cos(k*u*theta) + e_s*sin(k*u*theta)",
    reference="Lu and Trumper, IEEE Trans. Ind. Electron. 54 (2007) 2187",
    where="transmission_error at orders k*u",
    forms={TRANSMISSION_ERROR: (Form("harmonic", _eccentric, (E_C, E_S), (ORDER,), _grid),)},
    variables=("angle",),
)
