"""Zero of the torque sensor drifting with temperature."""

from __future__ import annotations

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import LOAD_TORQUE, MOTOR_TORQUE, Form, Point, Symbol, Term, columns


def _linear(frame: Frame, _: Point) -> FloatArray:
    return columns(frame.temperature - 25.0)


def _quadratic(frame: Frame, _: Point) -> FloatArray:
    rise = frame.temperature - 25.0
    return columns(rise, rise**2)


def _trace(frame: Frame, _: Point) -> FloatArray:
    return columns(-(frame.temperature - 25.0) / frame.ratio)


Z_T = Symbol("z_T", "N*m/K", "drift of the zero per kelvin")
Z_TT = Symbol("z_TT", "N*m/K^2", "curvature of the drift")

TERM = Term(
    effect="sensor.torque_zero_temperature",
    name="zero of the torque sensor drifting with temperature",
    equation="load_torque += z_T*(T - 25 degC)",
    reference="VDI/VDE 2646; data sheets' TK0",
    where="load_torque as an offset that follows the temperature",
    forms={
        LOAD_TORQUE: (
            Form("linear", _linear, (Z_T,)),
            Form(
                "quadratic",
                _quadratic,
                (Z_T, Z_TT),
                equation="load_torque += z_T*(T - 25 degC) + z_TT*(T - 25 degC)**2",
            ),
        ),
        MOTOR_TORQUE: (Form("linear", _trace, (Z_T,), equation="tau_m -= z_T*(T - 25 degC)/u"),),
    },
    variables=("temperature",),
    shape={LOAD_TORQUE: (("temperature", "1"),)},
)
