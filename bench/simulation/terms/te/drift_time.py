"""Slow change with time, not with temperature: creep, wear, loosening."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame, recording_starts
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Point, Symbol, Term, columns

EVEN = 22
"""moments of a step at even distances"""
MOST_GAPS = 60
"""gaps between recordings in which a step is looked for"""


def _linear(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.time / 3600.0)


def _scales(frame: Frame) -> tuple[Point, ...]:
    span = float(np.ptp(frame.time)) or 1.0
    return tuple((span * share,) for share in (0.03, 0.08, 0.2, 0.5))


def _creep(frame: Frame, point: Point) -> FloatArray:
    return columns(1.0 - np.exp(-frame.time / point[0]))


def _logarithmic(frame: Frame, point: Point) -> FloatArray:
    return columns(np.log1p(frame.time / point[0]))


def _steps(frame: Frame) -> tuple[Point, ...]:
    # a step has no slope by which its moment is refined: it stands in the very gap between two recordings, or at even
    # moments inside of a long one, and anywhere where there are few gaps
    span = float(np.ptp(frame.time)) or 1.0
    even = span * np.linspace(0.08, 0.92, EVEN)
    starts = recording_starts(frame)
    first, last = frame.time[starts[:-1]], frame.time[starts[1:] - 1]
    between = 0.5 * (last[:-1] + first[1:])[first[1:] > last[:-1]]
    if between.size > MOST_GAPS:
        between = between[np.unique(np.round(np.linspace(0, between.size - 1, MOST_GAPS)).astype(int))]
    if between.size >= EVEN:
        long = last - first > span / EVEN
        even = even[[bool(np.any(long & (first < moment) & (moment < last))) for moment in even]]
    return tuple((float(moment),) for moment in np.sort([*even, *between]))


def _loosening(frame: Frame, point: Point) -> FloatArray:
    return columns((frame.time > point[0]).astype(np.float64))


def _travelled(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.travel / 100.0)


def _compliance(frame: Frame, _: Point) -> FloatArray:
    hours = frame.time / 3600.0
    return columns(hours, hours * frame.torque / 1000.0)


C_T = Symbol("c_t", "rad/h", "drift an hour")
C_E = Symbol("c_e", "rad", "drift in the end")
C_L = Symbol("c_l", "rad", "drift per factor e of time")
C_S = Symbol("c_s", "rad", "step of the offset")
C_D = Symbol("c_d", "rad", "drift per 100 rad run at the output")
C_K = Symbol("c_k", "rad/h", "growth of the compliance per kN*m and hour")
T_C = Symbol("t_c", "s", "time constant", 0.0)

TERM = Term(
    effect="te.drift_time",
    name="slow drift of the transmission error with time",
    equation="TE += c_t*t; or creep c_e*(1 - exp(-t/t_c)); or a step when something loosened",
    reference="Findley, Creep and Relaxation (1976); ISO 230-3 for drift tests",
    where="transmission_error's offset through the campaign",
    forms={
        TRANSMISSION_ERROR: (
            Form("linear", _linear, (C_T,), equation="TE += c_t*t"),
            Form("creep", _creep, (C_E,), (T_C,), _scales, equation="TE += c_e*(1 - exp(-t/t_c))"),
            Form("logarithmic", _logarithmic, (C_L,), (T_C,), _scales, equation="TE += c_l*log(1 + t/t_c)"),
            Form("loosening", _loosening, (C_S,), (T_C,), _steps, equation="TE += c_s, after t = t_c"),
            Form("distance", _travelled, (C_D,), equation="TE += c_d*s/(100 rad), s: distance run at the output"),
            Form("compliance", _compliance, (C_T, C_K), equation="TE += c_t*t + c_k*t*tau/(1 kN*m)"),
        )
    },
    variables=("time",),
    shape={TRANSMISSION_ERROR: (("time", "1"),)},
    any_function=True,
    one_way=True,
)
