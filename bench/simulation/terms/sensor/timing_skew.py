"""A constant delay of the torque channel against the angles: seen where the torque changes."""

from __future__ import annotations

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import (
    LOAD_TORQUE,
    MOTOR_TORQUE,
    TRANSMISSION_ERROR,
    Form,
    Point,
    Symbol,
    Term,
    columns,
)


def _rate(frame: Frame, _: Point) -> FloatArray:
    return columns(-frame.torque_rate)


def _motor_rate(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.torque_rate / frame.ratio)


def _compliance_rate(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.torque_rate)


DELAY = Symbol("delta", "s", "delay of the torque channel", -1.0, 1.0)
DELAY_K = Symbol("delta_over_k", "rad*s/(N*m)", "delay of the torque channel over the torsional stiffness")

TERM = Term(
    effect="sensor.timing_skew",
    name="delay of the torque channel",
    equation="load_torque(t) is the torque at t - delta: load_torque -= delta*dtau/dt; tau_m += delta*dtau/dt/u",
    reference="first-order expansion of a delay",
    where="wherever the load torque changes: torque ramps, reversals",
    forms={
        LOAD_TORQUE: (Form("delay", _rate, (DELAY,), equation="load_torque -= delta*dtau/dt"),),
        MOTOR_TORQUE: (Form("delay", _motor_rate, (DELAY,), equation="tau_m += delta*dtau/dt/u"),),
        TRANSMISSION_ERROR: (Form("delay", _compliance_rate, (DELAY_K,), equation="TE += delta_over_k*dtau/dt"),),
    },
    variables=("torque_rate",),
)
