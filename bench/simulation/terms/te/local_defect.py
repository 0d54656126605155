"""A damaged pin, lobe or tooth: a short pulse at fixed output angles."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Point, Symbol, Term, columns
from bench.simulation.waves import angle_from


def _angles(_: Frame) -> tuple[Point, ...]:
    return tuple(
        (float(angle), width)
        for width in (0.008, 0.02, 0.05, 0.12)
        for angle in np.arange(0.0, 2.0 * np.pi, max(width, 0.01))
    )


def _gaussian(frame: Frame, point: Point) -> FloatArray:
    return columns(np.exp(-0.5 * (angle_from(frame.theta, point[0]) / point[1]) ** 2))


def _raised_cosine(frame: Frame, point: Point) -> FloatArray:
    x = np.clip(angle_from(frame.theta, point[0]) / (2.5 * point[1]), -1.0, 1.0)
    return columns(0.5 * (1.0 + np.cos(np.pi * x)))


P = Symbol("p", "rad", "height of the pulse")
ANGLE = Symbol("theta_p", "rad", "angle of the pulse, modulo 2*pi", 0.0, 2.0 * np.pi)
WIDTH = Symbol("w_p", "rad", "width of the pulse (standard deviation)", 0.0)

TERM = Term(
    effect="te.local_defect",
    name="local defect: a pulse at a fixed angle",
    equation="TE += p*exp(-((theta - theta_p)/w_p)**2/2), periodic in 2*pi",
    reference="Braun, Mechanical Signature Analysis (1986); Dalpiaz et al., Mech. Syst. Signal Process. 14 (2000) 387",
    where="transmission_error at fixed output angles",
    forms={
        TRANSMISSION_ERROR: (
            Form("gaussian", _gaussian, (P,), (ANGLE, WIDTH), _angles),
            Form(
                "raised_cosine",
                _raised_cosine,
                (P,),
                (ANGLE, WIDTH),
                _angles,
                equation=(
                    "TE += p*(1 + cos(pi*x))/2, x = max(-1, min(1, (theta - theta_p)/(2.5*w_p))), periodic in 2*pi"
                ),
            ),
        )
    },
    variables=("angle",),
)
