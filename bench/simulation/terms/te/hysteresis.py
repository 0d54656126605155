"""Path dependence of the offset: on the torque's path, or on the distance after a reversal."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import begins, play, relaxing
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Point, Symbol, Term, columns, logarithmic
from bench.simulation.terms.loops import Loops


def _travels(_: Frame) -> tuple[Point, ...]:
    # shorter than a tenth of a degree is over within the smoothing of the speed
    return logarithmic(2.5e-3, 0.3, 10)


def _after_reversal(frame: Frame, point: Point) -> FloatArray:
    state = relaxing(frame.theta, frame, point[0])
    return columns(np.where(frame.direction != 0, state - frame.last_direction, 0.0))


def _angle_play(frame: Frame, point: Point) -> FloatArray:
    half = 0.5 * point[0]
    z = (frame.theta - play(frame.theta, frame, half)) / half
    return columns(np.clip(z, -1.0, 1.0) - frame.last_direction)


H = Symbol("h", "rad", "half width of the loop")
S = Symbol("s", "rad", "distance at the output over which the loop turns", 0.0)
LOOPS = Loops(
    level=lambda frame: frame.torque_level,
    torque="tau",
    output="TE",
    size=H,
    width=Symbol("w", "N*m", "torque over which the loop turns", 0.0),
    rate=Symbol("r", "1/s", "rate at which the loop forgets, for the torque wavers to and fro", 0.0),
    in_motion=Symbol(
        "k", "1/rad", "rate at which the loop forgets in motion, for the torque wavers with the angle (dither)", 0.0
    ),
    relaxing="bouc_wen",
)
_REVERSAL = "TE += h*(z - d), dz = (1 - z*sgn(dx))*dx/s, x = theta, nothing at standstill"
_ANGLE_PLAY = "TE += h*(z - d), z = 2*(theta - y)/s, y = max(theta - s/2, min(theta + s/2, y))"

TERM = Term(
    effect="te.hysteresis",
    name="hysteresis of the transmission",
    equation="TE += h*z, dz = (1 - z*sgn(dx))*dx/w, x the torque (or the angle); or play of half width w",
    reference="Bouc 1967; Wen, J. Eng. Mech. 102 (1976) 249; Iwan 1966; Mesmer et al., IEEE AIM 2022",
    where="transmission_error's offset, by whether the torque rises or falls, or after reversal",
    forms={
        TRANSMISSION_ERROR: (
            *LOOPS.forms(),
            Form(
                "reversal",
                _after_reversal,
                (H,),
                (S,),
                _travels,
                equation=f"{_REVERSAL}, {begins('z', 'fresh')}",
            ),
            Form(
                "angle_play",
                _angle_play,
                (H,),
                (S,),
                _travels,
                equation=f"{_ANGLE_PLAY}, {begins('y', 'fresh')}",
            ),
        )
    },
    variables=("torque_path", "since_reversal"),
)
