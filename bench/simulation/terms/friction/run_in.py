"""Run-in: friction that decays with the distance or the time run."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import warmed_between
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns, logarithmic

LEAST_WARMED = 1.0
"""K by which a gearbox has to be warmed between recordings, in all, before that tells of a distance run there: less may
be a room's, or the noise of a thermometer added up
"""
FURTHER = (1.0, 4.0, 16.0)
"""distances that are tried between recordings, over that in them"""


def _distances(frame: Frame) -> tuple[Point, ...]:
    span = float(np.ptp(frame.travel)) or 1.0
    return logarithmic(0.02 * span, 1.5 * span, 9)


def _times(frame: Frame) -> tuple[Point, ...]:
    span = float(np.ptp(frame.time)) or 1.0
    return logarithmic(0.02 * span, 1.5 * span, 9)


def _by_distance(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.direction * np.exp(-frame.travel / point[0]))


def _by_time(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.direction * np.exp(-frame.time / point[0]))


def _hyperbolic(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.direction / (1.0 + frame.travel / point[0]))


def _root(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.direction / np.sqrt(1.0 + frame.travel / point[0]))


def _viscous(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.omega * np.exp(-frame.travel / point[0]))


def _logarithmic(frame: Frame, point: Point) -> FloatArray:
    return columns(-frame.direction * np.log1p(frame.travel / point[0]))


def _between(frame: Frame) -> tuple[Point, ...]:
    warmer = float(np.max(warmed_between(frame), initial=0.0))
    span = float(np.ptp(frame.travel)) or 1.0
    if warmer < LEAST_WARMED:
        return ()
    return tuple(
        (share * span * (1.0 + further), further * span / warmer)
        for further in FURTHER
        for share in (0.03, 0.1, 0.3, 1.0)
    )


def _with_unrecorded(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.direction * np.exp(-_distance(frame, point) / point[0]))


def _hyperbolic_with_unrecorded(frame: Frame, point: Point) -> FloatArray:
    return columns(frame.direction / (1.0 + _distance(frame, point) / point[0]))


def _distance(frame: Frame, point: Point) -> FloatArray:
    return frame.travel + point[1] * warmed_between(frame)


F_R = Symbol("f_r", "N*m", "extra friction of the new gearbox", 0.0)
F_RV = Symbol("f_rv", "N*m*s/rad", "extra viscous friction of the new gearbox", 0.0)
S_R = Symbol("s_r", "rad", "distance at the output over which it decays", 0.0)
K_R = Symbol("k_r", "rad/K", "distance run between recordings for each K by which the gearbox was warmer after it", 0.0)
T_R = Symbol("t_r", "s", "time over which it decays", 0.0)

_UNRECORDED = (
    ("with_unrecorded", _with_unrecorded, "d*f_r*exp(-(s + k_r*W)/s_r)"),
    ("hyperbolic_with_unrecorded", _hyperbolic_with_unrecorded, "d*f_r/(1 + (s + k_r*W)/s_r)"),
)
"""forms of a distance that was not recorded: name, decay, and what of its equation is its own"""
_WARMED = ", s: distance run at the output, W: rises of the temperature between recordings, summed up"

TERM = Term(
    effect="friction.run_in",
    name="running-in of the friction",
    equation="tau_m += d * f_r * exp(-s/s_r), s: distance run; or exp(-t/t_r)",
    reference="Blau, Tribol. Int. 38 (2005) 1007",
    where="motor_torque, falling through the campaign whatever the temperature",
    forms={
        MOTOR_TORQUE: (
            Form(
                "distance",
                _by_distance,
                (F_R,),
                (S_R,),
                _distances,
                equation="tau_m += d*f_r*exp(-s/s_r), s: distance run at the output",
            ),
            Form(
                "time", _by_time, (F_R,), (T_R,), _times, shape=(("time", "d"),), equation="tau_m += d*f_r*exp(-t/t_r)"
            ),
            Form(
                "hyperbolic",
                _hyperbolic,
                (F_R,),
                (S_R,),
                _distances,
                equation="tau_m += d*f_r/(1 + s/s_r), s: distance run at the output",
            ),
            Form(
                "root",
                _root,
                (F_R,),
                (S_R,),
                _distances,
                equation="tau_m += d*f_r/sqrt(1 + s/s_r), s: distance run at the output",
            ),
            Form(
                "logarithmic",
                _logarithmic,
                (F_R,),
                (S_R,),
                _distances,
                equation="tau_m -= d*f_r*log(1 + s/s_r), s: distance run at the output",
            ),
            Form(
                "viscous",
                _viscous,
                (F_RV,),
                (S_R,),
                _distances,
                equation="tau_m += f_rv*w_m*exp(-s/s_r), s: distance run at the output",
            ),
            *(
                Form(name, decay, (F_R,), (S_R, K_R), _between, remembers=True, equation=f"tau_m += {text}{_WARMED}")
                for name, decay, text in _UNRECORDED
            ),
        )
    },
    variables=("time",),
    one_way=True,
    modifies=("friction.coulomb",),
    shape={MOTOR_TORQUE: (("travel", "d"),)},
)
