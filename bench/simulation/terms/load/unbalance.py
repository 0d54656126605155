"""Gravity on an unbalanced mass at the output: one period a revolution of q."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import LOAD_TORQUE, MOTOR_TORQUE, Form, Point, Symbol, Term, columns


def _behind_sensor(frame: Frame, _: Point) -> FloatArray:
    return columns(np.sin(frame.q), np.cos(frame.q))


def _before_sensor(frame: Frame, _: Point) -> FloatArray:
    return columns(np.sin(frame.q) / frame.ratio, np.cos(frame.q) / frame.ratio)


M_S = Symbol("m_s", "N*m", "sine amplitude of the unbalance torque at the output")
M_C = Symbol("m_c", "N*m", "cosine amplitude of the unbalance torque at the output")

TERM = Term(
    effect="load.unbalance",
    name="unbalanced mass on the output",
    equation="load_torque (or u*tau_m) += m_s*sin(q) + m_c*cos(q)",
    reference="equilibrium of moments, m*g*r*sin(q + phi)",
    where="once an output revolution; before the torque sensor in motor_torque, behind it in load_torque",
    forms={
        LOAD_TORQUE: (Form("gravity", _behind_sensor, (M_S, M_C), equation="load_torque += m_s*sin(q) + m_c*cos(q)"),),
        MOTOR_TORQUE: (Form("gravity", _before_sensor, (M_S, M_C), equation="tau_m += (m_s*sin(q) + m_c*cos(q))/u"),),
    },
    variables=("angle",),
)
