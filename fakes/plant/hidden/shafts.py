"""Hidden torques at both shafts: motors, unbalance, what is dragged along; and the motor encoder's own error.

numba's cache knows the numbers of :mod:`kinds` as they were when this file was compiled (see :mod:`drag`).
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from fakes.plant.hidden.drag import springs
from fakes.plant.hidden.kinds import LOADED, MOTOR, NUMBER, TE

_RIPPLE, _GAIN, _SATURATION, _HOT = (
    NUMBER["ripple"],
    NUMBER["torque_gain"],
    NUMBER["saturation"],
    NUMBER["hot_magnets"],
)
_BEHIND, _BEFORE, _EDDY = NUMBER["unbalance_behind"], NUMBER["unbalance_before"], NUMBER["eddy"]
_HOSE, _FLOOR, _ECCENTRIC = NUMBER["hose"], NUMBER["floor"], NUMBER["eccentric"]
_ELECTRICAL = 24.0
"""sixth harmonic of four pole pairs, per turn of the motor"""


@njit(cache=True, error_model="numpy")
def _motor_torque(kind: int, q: Any, m: Any, s: Any, torque: float, step: float) -> float:
    """Return the torque on the motor shaft in addition to the one that the current stands for, N·m."""
    if kind == _RIPPLE:
        return float(q[0] * math.cos(_ELECTRICAL * s.motor_angle + q[1]))
    if kind == _GAIN:
        return float(-q[0] * torque)
    if kind == _SATURATION:
        share = (torque / q[1]) ** 2
        return float(-q[0] * torque * share / (1.0 + share))
    # _HOT, m[0]: how hot the winding is, 1 at steady rated current
    m[0] += step * (q[1] * torque * torque - m[0]) / q[2]
    return float(-q[0] * m[0] * torque)


@njit(cache=True, error_model="numpy")
def _output_torque(kind: int, q: Any, m: Any, p: Any, s: Any, step: float) -> float:
    """Return the torque on the output against the positive direction, N·m."""
    if kind in (_BEHIND, _BEFORE):
        return float(q[0] * math.sin(s.load_angle + q[1]))
    if kind == _EDDY:
        x = s.load_velocity / q[1]
        return float(2.0 * q[0] * x / (1.0 + x * x))
    if kind == _HOSE:
        # m[0]: stretch of the hose, rad; beyond its reach the clamp slips
        m[0] = min(max(m[0] + step * s.load_velocity, -q[1]), q[1])
        return float(q[0] * m[0] / q[1])
    return float(q[0] * math.sin(2.0 * math.pi * q[1] * s.cycle * p.cycle_time))


@njit(cache=True, error_model="numpy")
def torques(hidden: Any, p: Any, s: Any, now: Any, step: float) -> None:
    """Add the hidden torques of a drives' tick to those of both shafts."""
    kinds, parameters, memory, shown = hidden
    turned = s.motor_velocity * step
    # set anew by the drives in each tick, before this
    torque = now.motor_torque
    now.before_sensor = now.spring_torque = 0.0
    for i in range(kinds.shape[0]):
        kind = kinds[i]
        q, m = parameters[i], memory[i]
        spring = springs(kind, q, m, shown[i], s, turned, step)
        now.motor_torque -= spring
        now.spring_torque += spring
        if _RIPPLE <= kind <= _HOT:
            more = _motor_torque(kind, q, m, s, torque, step)
            now.motor_torque += more
            shown[i, MOTOR] = -more
        elif _BEHIND <= kind <= _FLOOR:
            against = _output_torque(kind, q, m, p, s, step)
            now.load_torque -= against
            if kind == _BEFORE:
                now.before_sensor += against
                shown[i, MOTOR] = against / p.ratio
            else:
                shown[i, LOADED] = against


@njit(cache=True, error_model="numpy")
def misread(hidden: Any, p: Any, s: Any) -> float:
    """Return what the motor encoder reads beyond the angle of its shaft, rad."""
    kinds, parameters, _memory, shown = hidden
    total = 0.0
    for i in range(kinds.shape[0]):
        if kinds[i] == _ECCENTRIC:
            q = parameters[i]
            off = q[0] * (math.cos(s.motor_angle + q[1]) + q[2] * math.cos(2.0 * s.motor_angle - q[1]))
            shown[i, TE] = -off / p.ratio
            total += off
    return total
