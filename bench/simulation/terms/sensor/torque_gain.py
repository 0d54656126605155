"""Gain error of the torque sensor: in load_torque, with a trace in motor_torque."""

from __future__ import annotations

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import LOAD_TORQUE, MOTOR_TORQUE, Form, Point, Symbol, Term, columns


def _gain(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.load_motor_level)


def _warming(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.load_motor_level, frame.load_motor_level * (frame.temperature - 25.0))


def _trace(frame: Frame, _: Point) -> FloatArray:
    return columns(-frame.torque / frame.ratio)


G_S = Symbol("g_s", "1", "gain error of the torque sensor", -0.9, 4.0)
G_T = Symbol("g_T", "1/K", "change of the gain per kelvin")

TERM = Term(
    effect="sensor.torque_gain",
    name="gain error of the torque sensor",
    equation="load_torque += g_s*load_motor_torque, or (g_s + g_T*(T - 25 degC))*load_motor_torque; tau_m -= g_s*tau/u",
    reference="VDI/VDE 2646; data sheets' sensitivity tolerance, and temperature effect on sensitivity (TCS, TKC)",
    where="load_torque in proportion to the load, with the opposite trace in motor_torque",
    forms={
        LOAD_TORQUE: (
            Form("gain", _gain, (G_S,), equation="load_torque += g_s*load_motor_torque"),
            Form(
                "temperature",
                _warming,
                (G_S, G_T),
                shape=(("temperature", "load_motor"),),
                equation="load_torque += (g_s + g_T*(T - 25 degC))*load_motor_torque",
                variables=("torque", "temperature"),
            ),
        ),
        # in the motor torque alone a gain that grows with temperature is as well that of the motor's magnets
        MOTOR_TORQUE: (Form("gain", _trace, (G_S,), equation="tau_m -= g_s*tau/u"),),
    },
    variables=("torque",),
)
