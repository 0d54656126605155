"""Pre-sliding: friction that builds up over a distance after standstill or reversal."""

from __future__ import annotations

from itertools import product

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import Between, begins, relaxing
from bench.simulation.terms.base import (
    MOTOR_TORQUE,
    Columns,
    Form,
    Grid,
    Point,
    Symbol,
    Term,
    columns,
    logarithmic,
    slow_speed,
    top,
)

SHORTEST, LONGEST = 0.05, 40.0
"""rad at the motor: distances of gearboxes and motors; other machines, linear ones above all, have their own"""
ROWS = 2.0
"""rows within which nothing is told of how friction builds up: it may as well pass through zero with the speed"""
JUST_AFTER_S = 1.5
"""after a reversal, in which friction builds up"""
PART = 300.0
"""part of the distance between two reversals that is still looked at"""
HIGHER = (0.25, 1.0)
"""by how much friction at standstill is above that in motion: shares of this that are tried"""
STRIBECK = "friction.stribeck"
"""id of the friction that decays with speed, without springs"""


def _grid(frame: Frame) -> tuple[Point, ...]:
    run = _between_reversals(frame)
    if run <= 0.0:
        return logarithmic(SHORTEST, LONGEST, 14)
    # between speeds that were set, levels tell how much is missing; elsewhere only rows just after a reversal do
    resolution = 0.0 if np.any(frame.steady > 0.5) else ROWS * _in_a_row(frame)
    return logarithmic(max(min(SHORTEST, run / PART), resolution), min(LONGEST, run), 14)


def _between_reversals(frame: Frame) -> float:
    """Median distance at the motor's shaft from a reversal to the next, or to the recording's end; 0 where none."""
    travel = np.abs(frame.reversal_travel) * frame.ratio
    ends = (np.diff(frame.recording, append=-1) != 0) | (np.diff(travel, append=0.0) < 0.0)
    runs = travel[ends & (frame.reversed_before > 0) & (travel > 0.0)]
    return float(np.median(runs)) if runs.size else 0.0


def _in_a_row(frame: Frame) -> float:
    """Distance at the motor's shaft from row to row just after reversals, in the finer of the recordings; 0 where there
    are none.
    """
    step = np.abs(np.diff(frame.theta, prepend=frame.theta[0])) * frame.ratio
    just = (frame.reversed_before > 0) & (frame.reversal_time < JUST_AFTER_S) & (frame.direction != 0)
    just[0] = False
    just[1:] &= frame.recording[1:] == frame.recording[:-1]
    of = frame.recording[just]
    each = [float(np.median(step[just][of == number])) for number in np.unique(of)]
    return float(np.quantile(each, 0.25)) if each else 0.0


def _springs(between: Between) -> Columns:
    """Springs that stretch to the Coulomb friction (point: the distance over which they do) or, with two more numbers,
    to a Stribeck curve in its place (by how much that is higher, and its speed).
    """

    def state_columns(frame: Frame, point: Point) -> FloatArray:
        scale, *curve = point
        height = 1.0 + curve[0] * np.exp(-((np.abs(frame.omega) / curve[1]) ** 2)) if curve else 1.0
        state = relaxing(frame.theta * frame.ratio, frame, scale, between, height=height)
        return columns(np.where(frame.direction != 0, state - frame.direction, 0.0))

    return state_columns


def _lugre_grid(frame: Frame) -> tuple[Point, ...]:
    slowest = slow_speed(frame.omega)
    speeds = logarithmic(3.0 * slowest, max(min(0.5 * top(frame.omega), 40.0 * slowest), 6.0 * slowest), 3)
    return tuple((s, b, w) for (s,), b, (w,) in product(_grid(frame)[::2], HIGHER, speeds))


def _since_reversal(frame: Frame, point: Point) -> FloatArray:
    lag = np.exp(-frame.reversal_travel * frame.ratio / point[0]) * frame.reversed_before
    return columns(-frame.direction * lag)


def _linear(frame: Frame, point: Point) -> FloatArray:
    lag = np.maximum(0.0, 1.0 - frame.reversal_travel * frame.ratio / (2.0 * point[0])) * (1.0 + frame.reversed_before)
    return columns(-frame.direction * lag)


F_D = Symbol("f_d", "N*m", "friction that needs a distance to build up", 0.0)
S_D = Symbol("s_d", "rad", "distance at the motor shaft over which it builds up", 0.0)
B_S = Symbol("b_s", "1", "share by which friction at standstill is above that in motion", 0.0)
W_S = Symbol("w_s", "rad/s", "Stribeck speed of the motor shaft", 0.0)

_LUGRE = "tau_m += f_d*(z - d), dz = (1 - z*sgn(dx)/h)*dx/s_d, h = 1 + b_s*exp(-(w_m/w_s)**2), x = phi, nothing at rest"
_DAHL = "tau_m += f_d*(z - d), dz = (1 - z*sgn(dx))*dx/s_d, x = phi, nothing at rest"
_WAY = "x: way of the motor since the start and each reversal"


def _fresh_and_kept(
    name: str, point: tuple[Symbol, ...], grid: Grid, equation: str, says: tuple[str, ...] = ()
) -> tuple[Form, Form]:
    """Springs that begin anew in each recording, and that a machine which stands between two keeps as they were."""

    def form(suffix: str, between: Between, *, kept: bool) -> Form:
        return Form(
            f"{name}{suffix}",
            _springs(between),
            (F_D,),
            point,
            grid,
            remembers=kept,
            jumps=kept,
            equation=f"{equation}, {begins('z', between)}",
            says=says,
        )

    return form("", "fresh", kept=False), form("_kept", "kept", kept=True)


TERM = Term(
    effect="friction.presliding",
    name="pre-sliding friction after reversal",
    equation="tau_m += f_d * (z - d), dz = (1 - z*sgn(dphi)) * dphi / s_d",
    reference="Dahl, TOR-158, Aerospace Corp. 1968; Canudas de Wit et al., IEEE TAC 40 (1995) 419",
    where="motor_torque in the first moments after a start or reversal",
    forms={
        MOTOR_TORQUE: (
            *_fresh_and_kept("dahl", (S_D,), _grid, _DAHL),
            *_fresh_and_kept("lugre", (S_D, B_S, W_S), _lugre_grid, _LUGRE, (STRIBECK,)),
            Form(
                "reversal",
                _since_reversal,
                (F_D,),
                (S_D,),
                _grid,
                equation=f"tau_m -= d*f_d*exp(-x/s_d), {_WAY}, nothing before the first reversal",
            ),
            Form(
                "linear",
                _linear,
                (F_D,),
                (S_D,),
                _grid,
                equation=f"tau_m -= d*f_d*(1 + r)*max(1 - x/(2*s_d), 0), {_WAY}, r = 1 after a reversal, r = 0 before",
            ),
        )
    },
    variables=("since_reversal",),
    modifies=("friction.coulomb",),
    shape={MOTOR_TORQUE: (("since_reversal", "d*reversed"),)},
)
