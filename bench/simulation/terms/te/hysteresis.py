"""Path dependence of the offset: on the torque's path, or on the distance after a reversal."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Grid, Point, Symbol, Term, columns, logarithmic, top
from bench.simulation.terms.memory import play, relaxing


def _torques(frame: Frame) -> tuple[Point, ...]:
    largest = top(frame.torque)
    return logarithmic(0.06 * largest, 0.8 * largest, 9)


def _play(frame: Frame, point: Point) -> FloatArray:
    return columns((frame.torque - play(frame.torque, frame, point[0])) / point[0])


def _play_kept(frame: Frame, point: Point) -> FloatArray:
    return columns((frame.torque - play(frame.torque, frame, point[0], keep=True)) / point[0])


def _quiet(frame: Frame) -> FloatArray:
    return play(frame.torque, frame, 0.03 * top(frame.torque))


def _bouc_wen(frame: Frame, point: Point) -> FloatArray:
    return columns(relaxing(_quiet(frame), frame, point[0]))


def _bouc_wen_kept(frame: Frame, point: Point) -> FloatArray:
    return columns(relaxing(_quiet(frame), frame, point[0], keep=True))


def _travels(_: Frame) -> tuple[Point, ...]:
    return logarithmic(2e-4, 0.3, 12)


def _after_reversal(frame: Frame, point: Point) -> FloatArray:
    state = relaxing(frame.theta, frame, point[0])
    return columns(np.where(frame.direction != 0, state - frame.last_direction, 0.0))


def _angle_play(frame: Frame, point: Point) -> FloatArray:
    half = 0.5 * point[0]
    z = (frame.theta - play(frame.theta, frame, half)) / half
    return columns(np.clip(z, -1.0, 1.0) - frame.last_direction)


H = Symbol("h", "rad", "half width of the loop")
W = Symbol("w", "N*m", "torque over which the loop turns", 0.0)
S = Symbol("s", "rad", "distance at the output over which the loop turns", 0.0)


def _form(name: str, function: object, symbol: Symbol, grid: Grid) -> Form:
    return Form(name, function, (H,), (symbol,), grid)  # type: ignore[arg-type]


TERM = Term(
    effect="te.hysteresis",
    name="hysteresis of the transmission",
    equation="TE += h*z, dz = (1 - z*sgn(dx))*dx/w, x the torque (or the angle); or play of half width w",
    reference="Bouc 1967; Wen, J. Eng. Mech. 102 (1976) 249; Iwan 1966; Mesmer et al., IEEE AIM 2022",
    where="transmission_error's offset, by whether the torque rises or falls, or after reversal",
    forms={
        TRANSMISSION_ERROR: (
            _form("play", _play, W, _torques),
            _form("play_kept", _play_kept, W, _torques),
            _form("bouc_wen", _bouc_wen, W, _torques),
            _form("bouc_wen_kept", _bouc_wen_kept, W, _torques),
            _form("reversal", _after_reversal, S, _travels),
            _form("angle_play", _angle_play, S, _travels),
        )
    },
    variables=("torque_path", "since_reversal"),
)
