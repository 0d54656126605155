"""A harmonic order the simulation does not have."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Point, Symbol, Term, columns


def _orders(_: Frame) -> tuple[Point, ...]:
    return tuple((float(order),) for order in range(1, 701))


def _constant(frame: Frame, point: Point) -> FloatArray:
    angle = point[0] * frame.theta
    return columns(np.cos(angle), np.sin(angle))


def _states(frame: Frame) -> tuple[FloatArray, ...]:
    forward = frame.last_direction
    return (
        np.ones(frame.size),
        forward,
        frame.torque / 1000.0,
        frame.velocity / 0.1,
        (frame.temperature - 35.0) / 15.0,
    )


def _dependent(frame: Frame, point: Point) -> FloatArray:
    angle = point[0] * frame.theta
    return columns(*(state * wave for state in _states(frame) for wave in (np.cos(angle), np.sin(angle))))


C = Symbol("c", "rad", "cosine amplitude")
S = Symbol("s", "rad", "sine amplitude")
F = Symbol("f", "1", "order per output revolution", 0.0)
_DEPENDENT = tuple(
    Symbol(f"{wave}_{state}", "rad", f"{wave} amplitude, {meaning}")
    for state, meaning in (
        ("1", "constant"),
        ("d", "with the direction"),
        ("tau", "per kN*m"),
        ("v", "per 0.1 rad/s"),
        ("T", "per 15 K about 35 degC"),
    )
    for wave in ("c", "s")
)

_OF_STATES = ", ".join(
    f"{w} = {w}_1 + {w}_d*d + {w}_tau*tau/(1 kN*m) + {w}_v*dtheta/(0.1 rad/s) + {w}_T*(T - 35 degC)/(15 K)"
    for w in ("c", "s")
)

TERM = Term(
    effect="te.harmonic",
    name="harmonic order that the simulation does not have",
    equation="TE += c*cos(f*theta) + s*sin(f*theta)",
    reference="Bauer et al., ICIT 2025, eq. 3; Blanche and Yang, J. Mech. Des. 111 (1989)",
    where="transmission_error's order spectrum",
    forms={
        TRANSMISSION_ERROR: (
            Form("constant", _constant, (C, S), (F,), _orders, counts=True),
            Form(
                "dependent",
                _dependent,
                _DEPENDENT,
                (F,),
                _orders,
                equation=f"TE += c*cos(f*theta) + s*sin(f*theta), {_OF_STATES}",
            ),
        )
    },
    variables=("angle",),
)
