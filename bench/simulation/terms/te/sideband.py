"""Modulation of a known order f by m: the orders f - m and f + m together."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Point, Symbol, Term, columns


def _pairs(_: Frame) -> tuple[Point, ...]:
    return tuple((float(f), float(m)) for f in (24, 46, 90, 92, 135, 138, 180, 184, 276) for m in range(1, 7))


def _both(frame: Frame, point: Point) -> FloatArray:
    lower, upper = (point[0] - point[1]) * frame.theta, (point[0] + point[1]) * frame.theta
    return columns(np.cos(lower), np.sin(lower), np.cos(upper), np.sin(upper))


LOWER_C = Symbol("c_lower", "rad", "cosine amplitude at f - m")
LOWER_S = Symbol("s_lower", "rad", "sine amplitude at f - m")
UPPER_C = Symbol("c_upper", "rad", "cosine amplitude at f + m")
UPPER_S = Symbol("s_upper", "rad", "sine amplitude at f + m")
F = Symbol("f", "1", "order that is modulated", 0.0)
M = Symbol("m", "1", "order of the modulation", 0.0)

TERM = Term(
    effect="te.sideband",
    name="sidebands: a known order modulated",
    equation="TE += c_lower*cos((f-m)*theta) + s_lower*sin((f-m)*theta) + the same at f+m",
    reference="McFadden, Mech. Syst. Signal Process. 1 (1987) 173; Feng and Zuo, J. Sound Vib. 331 (2012) 4919",
    where="transmission_error's order spectrum, a pair about a known order",
    forms={
        TRANSMISSION_ERROR: (
            Form(
                "modulation",
                _both,
                (LOWER_C, LOWER_S, UPPER_C, UPPER_S),
                (F, M),
                _pairs,
                equation=(
                    "TE += c_lower*cos((f - m)*theta) + s_lower*sin((f - m)*theta) + c_upper*cos((f + m)*theta) "
                    "+ s_upper*sin((f + m)*theta)"
                ),
            ),
        )
    },
    variables=("angle",),
)
