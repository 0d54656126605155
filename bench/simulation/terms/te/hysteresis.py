"""Path dependence of the offset: on the torque's path, or on the distance after a reversal."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import FORGETS, NOISE_SHARE, RATES, Between, begins, play, relaxing
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

BETWEEN: tuple[Between, ...] = ("fresh", "kept", "released")
SUFFIX = {"fresh": "", "kept": "_kept", "released": "_released"}
WIDEST = 0.4
"""of the largest torque: a loop that is wider is hardly turned, and looks like a compliance"""
STACK = (0.4, 1.0, 2.2)
"""widths of a stack of plays, in units of its parameter"""


def _torques(frame: Frame) -> tuple[Point, ...]:
    largest = top(frame.torque)
    return logarithmic(0.06 * largest, WIDEST * largest, 8)


def _wide_torques(frame: Frame) -> tuple[Point, ...]:
    largest = top(frame.torque)
    return logarithmic(0.08 * largest, WIDEST * largest, 4)


def _play(between: Between) -> Columns:
    def regressors(frame: Frame, point: Point) -> FloatArray:
        return columns((frame.torque_level - play(frame.torque_level, frame, point[0], between)) / point[0])

    return regressors


def _stack(between: Between) -> Columns:
    def regressors(frame: Frame, point: Point) -> FloatArray:
        widths = [share * point[0] for share in STACK]
        return columns(*((frame.torque_level - play(frame.torque_level, frame, w, between)) / w for w in widths))

    return regressors


def _quiet(frame: Frame, width: float) -> FloatArray:
    """The torque without the sensor's noise, which would turn the loop by itself."""
    return play(frame.torque_level, frame, NOISE_SHARE * width)


def _bouc_wen(between: Between) -> Columns:
    def regressors(frame: Frame, point: Point) -> FloatArray:
        return columns(relaxing(_quiet(frame, point[0]), frame, point[0], between))

    return regressors


def _forgetting(frame: Frame, point: Point) -> FloatArray:
    return columns(relaxing(_quiet(frame, point[0]), frame, point[0], "fresh", point[1]))


def _forgetting_points(frame: Frame) -> tuple[Point, ...]:
    return tuple((w, rate) for (w,) in _wide_torques(frame) for rate in RATES)


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
H_STACK = tuple(
    Symbol(f"h_{k + 1}", "rad", f"half width of the loop of the play of {w:g}*w") for k, w in enumerate(STACK)
)
W = Symbol("w", "N*m", "torque over which the loop turns", 0.0)
RATE = Symbol("r", "1/s", "rate at which the loop forgets, for the torque wavers to and fro", 0.0)
S = Symbol("s", "rad", "distance at the output over which the loop turns", 0.0)
_PLAY = "TE += h*(tau - y)/w, y = max(tau - w, min(tau + w, y))"
_BOUC_WEN, _FORGETTING = (
    f"TE += h*z, dz = (1 - z*sgn(dx))*dx/w{forgets}, x = max(tau - {NOISE_SHARE:g}*w, min(tau + {NOISE_SHARE:g}*w, x))"
    for forgets in ("", FORGETS)
)
_STACK = "TE += {}, y_k = max(tau - w_k, min(tau + w_k, y_k)), {}".format(
    " + ".join(f"h_{k + 1}*(tau - y_{k + 1})/w_{k + 1}" for k in range(len(STACK))),
    ", ".join(f"w_{k + 1} = {f'{share:g}*' if share != 1.0 else ''}w" for k, share in enumerate(STACK)),
)
LOOPS = (
    ("play", _play, (H,), _torques, _PLAY, "y", 0.0),
    ("bouc_wen", _bouc_wen, (H,), _torques, _BOUC_WEN, "z", NOISE_SHARE),
    ("stack", _stack, H_STACK, _wide_torques, _STACK, "y_k", 0.0),
)
"""loops over the torque: name, regressors, sizes, grid of widths, equation and its state, what it leaves open of W"""
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
            *(
                Form(
                    f"{name}{SUFFIX[b]}",
                    make(b),
                    linear,
                    (W,),
                    grid,
                    one_sign=len(linear) > 1,
                    remembers=b != "fresh",
                    equation=f"{text}, {begins(state, b)}",
                    blur=blur,
                )
                for name, make, linear, grid, text, state, blur in LOOPS
                for b in BETWEEN
            ),
            Form(
                "forgetting",
                _forgetting,
                (H,),
                (W, RATE),
                _forgetting_points,
                equation=f"{_FORGETTING}, {begins('z', 'fresh')}",
                blur=NOISE_SHARE,
            ),
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
