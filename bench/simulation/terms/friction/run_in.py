"""Run-in: friction that decays with the distance or the time run."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import MOTOR_TORQUE, Form, Point, Symbol, Term, columns, logarithmic


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


F_R = Symbol("f_r", "N*m", "extra friction of the new gearbox", 0.0)
F_RV = Symbol("f_rv", "N*m*s/rad", "extra viscous friction of the new gearbox", 0.0)
S_R = Symbol("s_r", "rad", "distance at the output over which it decays", 0.0)
T_R = Symbol("t_r", "s", "time over which it decays", 0.0)

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
        )
    },
    variables=("time",),
    one_way=True,
    modifies=("friction.coulomb",),
    shape={MOTOR_TORQUE: (("travel", "d"),)},
)
