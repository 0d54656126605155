"""Hidden friction at the input shaft.

Each kind returns what it adds to the nominal law: a Coulomb part and a viscous part, both implicit in the mechanics as
the nominal ones are, and a torque against the motor that has a direction of its own (springs of asperities, scraper).

numba's cache knows the numbers of :mod:`kinds` as they were when this file was compiled: whoever moves a row there must
also touch this file.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from fakes.plant.hidden.kinds import MOTOR, NUMBER

_FIRST, _LAST = NUMBER["stribeck"], NUMBER["one_sided"]
_STRIBECK, _RATIONAL = NUMBER["stribeck"], NUMBER["stribeck_rational"]
_VISCOSITY, _VOGEL, _CHURNING = NUMBER["viscosity"], NUMBER["viscosity_vogel"], NUMBER["churning"]
_WAVE, _SPOT = NUMBER["tight_wave"], NUMBER["tight_spot"]
_RUN_IN, _RUN_IN_POWER = NUMBER["run_in"], NUMBER["run_in_power"]
_DAHL, _LUGRE, _MAXWELL = NUMBER["dahl"], NUMBER["lugre"], NUMBER["maxwell"]
_FLASH, _THIXOTROPY, _LIP, _SCRAPER = NUMBER["flash"], NUMBER["thixotropy"], NUMBER["dry_lip"], NUMBER["scraper"]
_PRELOAD, _SUMP, _ONE_SIDED = NUMBER["preload"], NUMBER["sump"], NUMBER["one_sided"]
_VOGEL_C = 95.0
"""°C below zero at which Vogel's viscosity would be without bound; mineral oils"""
_ELEMENTS = 4


@njit(cache=True, error_model="numpy")
def _by_state(kind: int, q: Any, p: Any, s: Any, speed: float, way: float) -> tuple[float, float]:
    """Return Coulomb and viscous part of kinds that remember nothing."""
    a = q[0]
    if kind == _STRIBECK:
        return a * math.exp(-((speed / q[1]) ** q[2])), 0.0
    if kind == _RATIONAL:
        return a / (1.0 + (speed / q[1]) ** q[2]), 0.0
    if kind == _VISCOSITY:
        return 0.0, a * math.exp(-(s.temperature - 25.0) / q[1])
    if kind == _VOGEL:
        warm, cold = s.temperature + _VOGEL_C, 25.0 + _VOGEL_C
        return 0.0, a * math.exp(cold * cold / q[1] * (1.0 / warm - 1.0 / cold))
    if kind == _CHURNING:
        return 0.0, a * speed ** (q[1] - 1.0)
    if kind == _WAVE:
        return a * (math.cos(q[1] * s.load_angle - q[2]) + 0.3 * math.cos(2.0 * q[1] * s.load_angle + q[2])), 0.0
    if kind == _SPOT:
        return a * math.exp(q[1] * (math.cos(s.load_angle - q[2]) - 1.0)), 0.0
    if kind == _RUN_IN:
        return a * math.exp(-s.travel / q[1]), 0.0
    if kind == _RUN_IN_POWER:
        return a * (1.0 + s.travel / q[1]) ** -0.8, 0.0
    if kind == _ONE_SIDED:
        lift = max(s.torque / q[1], 0.0) if way > 0.0 else 0.0
        return -a * lift / (1.0 + lift), 0.0
    return 0.0, 0.0


@njit(cache=True, error_model="numpy")
def _by_memory(kind: int, q: Any, m: Any, p: Any, s: Any, speed: float, way: float) -> tuple[float, float]:
    """Advance a slow memory by one cycle; return Coulomb and viscous part."""
    a, step, turned = q[0], p.cycle_time, speed * p.cycle_time / p.ratio
    if kind == _FLASH:
        # m[0]: K that the film is hotter than the lubricant; its own loss heats it, oil carries the heat away
        viscous = a * math.exp(-q[1] * m[0])
        m[0] += step * (viscous * speed * speed / q[2] - m[0] / q[3])
        return 0.0, viscous
    if kind == _THIXOTROPY:
        # m[0]: share of the grease's structure that is broken
        m[0] += step * (q[2] * speed * (1.0 - m[0]) - m[0] / q[1])
        return a * (1.0 - m[0]), 0.0
    if kind == _LIP:
        # m[0]: share of the lip that is dry
        m[0] += turned * (1.0 - m[0]) / q[1] if way > 0.0 else -turned * m[0] / q[2]
        return a * m[0], 0.0
    if kind == _PRELOAD:
        # m[0]: temperature of the outer ring; m[1]: whether it is known
        if m[1] == 0.0:
            m[0], m[1] = s.temperature, 1.0
        m[0] += step * (s.temperature - m[0]) / q[1]
        return a * max(s.temperature - m[0], 0.0), 0.0
    if kind == _SUMP:
        # m[0]: share of the oil that is out of the sump
        away = (speed / q[1]) ** 2
        m[0] += step * (away / (1.0 + away) - m[0]) / q[2]
        return 0.0, a * (1.0 - m[0])
    return 0.0, 0.0


@njit(cache=True, error_model="numpy")
def drag(hidden: Any, p: Any, s: Any, now: Any) -> None:
    """Add every friction that changes cycle by cycle to ``now`` and to what is shown."""
    kinds, parameters, memory, shown = hidden
    speed = abs(s.motor_velocity)
    way = math.copysign(1.0, s.motor_velocity) if speed > 0.0 else 0.0
    for i in range(kinds.shape[0]):
        kind = kinds[i]
        if kind < _FIRST or kind > _LAST:
            continue
        coulomb, viscous = _by_state(kind, parameters[i], p, s, speed, way)
        more, thick = _by_memory(kind, parameters[i], memory[i], p, s, speed, way)
        now.coulomb += coulomb + more
        now.viscous += viscous + thick
        shown[i, MOTOR] = way * (coulomb + more) + (viscous + thick) * s.motor_velocity
        if _DAHL <= kind <= _MAXWELL:
            # the springs below stand in for this much of the Coulomb friction
            now.coulomb -= parameters[i, 0]
    now.coulomb = max(now.coulomb, 0.0)
    now.viscous = max(now.viscous, 0.0)


@njit(cache=True, error_model="numpy")
def springs(kind: int, q: Any, m: Any, shown: Any, s: Any, turned: float, step: float) -> float:
    """Advance springs of asperities by ``turned`` (rad, motor); return their torque against the motor, N·m."""
    if kind == _SCRAPER:
        # m[0]: stretch; m[1]: chaotic number in (0, 1) that says at which stretch it snaps
        if m[1] == 0.0:
            m[1] = 0.37
        m[0] += turned
        if abs(m[0]) > q[1] * (0.5 + m[1]):
            m[0] *= 0.1
            m[1] = 3.97 * m[1] * (1.0 - m[1])
        torque = q[0] * m[0] / q[1]
        shown[MOTOR] = torque
        return float(torque)
    if kind < _DAHL or kind > _MAXWELL:
        return 0.0
    way = math.copysign(1.0, turned) if turned != 0.0 else 0.0
    if kind == _MAXWELL:
        total = 0.0
        for k in range(_ELEMENTS):
            slip_distance = q[1] * 0.4 * (k + 1)
            m[k] = min(max(m[k] + turned / slip_distance, -1.0), 1.0)
            total += m[k] / _ELEMENTS
    else:
        height = 1.0
        if kind == _LUGRE:
            height += q[2] * math.exp(-((s.motor_velocity / q[3]) ** 2))
        share = math.exp(-abs(turned) / (q[1] * height))
        m[0] = way * height + (m[0] - way * height) * share
        total = m[0]
    shown[MOTOR] = q[0] * (total - (math.copysign(1.0, s.motor_velocity) if s.motor_velocity != 0.0 else 0.0))
    return float(q[0] * total)
