"""Hidden kinematic error: what adds to the series over the angle, with its derivative.

numba's cache knows the numbers of :mod:`kinds` as they were when this file was compiled (see :mod:`drag`).
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from fakes.plant.hidden.kinds import NUMBER, TE

_LAST = NUMBER["cage"]
_HARMONIC, _SIDEBAND, _DEFECT, _RESONANCE = (
    NUMBER["harmonic"],
    NUMBER["sideband"],
    NUMBER["defect"],
    NUMBER["resonance"],
)
_CREEP, _LOG_CREEP, _FILM, _RATIONAL = NUMBER["creep"], NUMBER["log_creep"], NUMBER["film"], NUMBER["film_rational"]
_WARM, _CAGE = NUMBER["warm_step"], NUMBER["cage"]


@njit(cache=True, error_model="numpy")
def _over_angle(kind: int, q: Any, s: Any, theta: float) -> tuple[float, float]:
    """Return value and derivative of what is tied to the angle."""
    if kind == _HARMONIC:
        a = q[0] * (1.0 + q[3] * s.te_torque / 1000.0)
        return a * math.sin(q[1] * theta + q[2]), a * q[1] * math.cos(q[1] * theta + q[2])
    if kind == _SIDEBAND:
        carrier, beat = q[1] * theta + q[2], q[3] * theta + q[4]
        value = q[0] * math.sin(carrier) * math.cos(beat)
        first = q[1] * math.cos(carrier) * math.cos(beat) - q[3] * math.sin(carrier) * math.sin(beat)
        return value, q[0] * first
    value = q[0] * math.exp(q[1] * (math.cos(theta - q[2]) - 1.0))
    return value, -q[1] * math.sin(theta - q[2]) * value


@njit(cache=True, error_model="numpy")
def _level(kind: int, q: Any, p: Any, s: Any) -> float:
    """Return what shifts the level, the same at every angle."""
    time = s.cycle * p.cycle_time
    if kind == _CREEP:
        return float(q[0] * (1.0 - math.exp(-time / q[1])))
    if kind == _LOG_CREEP:
        return float(q[0] * math.log(1.0 + time / q[1]))
    if kind == _FILM:
        return float(q[0] * math.exp(-abs(s.te_velocity) / q[1]))
    if kind == _RATIONAL:
        return float(q[0] / (1.0 + (s.te_velocity / q[1]) ** 2))
    return float(q[0] * math.tanh((s.temperature - q[1]) / q[2]))


@njit(cache=True, error_model="numpy")
def _resonate(q: Any, m: Any, p: Any, s: Any, value: float, first: float) -> tuple[float, float]:
    """Drive the resonator with the series ``value``; return what its swing adds, and the derivative in θ.

    m[0], m[1]: its deflection and rate. It follows slow waves and swings up near its own frequency, q[1] in rad/s.
    """
    step = p.cycle_time
    m[1] += step * (q[1] * q[1] * (value - m[0]) - 2.0 * q[2] * q[1] * m[1])
    m[0] += step * m[1]
    rate = s.motor_velocity / p.ratio
    slope = m[1] / rate - first if abs(rate) > 1e-3 else 0.0
    return q[0] * (m[0] - value), q[0] * slope


@njit(cache=True, error_model="numpy")
def shape(hidden: Any, p: Any, s: Any, now: Any, level: float) -> None:
    """Add to the series in ``now`` and to what is shown; ``level`` is the series' own offset, rad."""
    kinds, parameters, memory, shown = hidden
    swinging, swinging_first = now.te_value - level, now.te_first
    theta = s.motor_angle / p.ratio
    for i in range(kinds.shape[0]):
        kind = kinds[i]
        if kind > _LAST:
            continue
        q, m = parameters[i], memory[i]
        if kind <= _DEFECT:
            value, first = _over_angle(kind, q, s, theta)
        elif kind == _RESONANCE:
            value, first = _resonate(q, m, p, s, swinging, swinging_first)
        elif kind == _CAGE:
            # m[0]: turns of the cage; little load lets it slip against the shaft
            rolls = 1.0 - q[2] / (1.0 + (s.te_torque / q[3]) ** 2)
            m[0] += q[1] * rolls * s.motor_velocity / p.ratio * p.cycle_time
            value, first = q[0] * math.sin(m[0]), q[0] * q[1] * rolls * math.cos(m[0])
        else:
            value, first = _level(kind, q, p, s), 0.0
        now.te_value += value
        now.te_first += first
        shown[i, TE] = value
