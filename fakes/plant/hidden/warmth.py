"""Hidden heat: what changes the lubricant's balance or how the PT100 follows it, and the torque sensor's own faults.

What an effect does to the temperature is kept beside it, as the difference to a lubricant without the effect, which the
nominal cooling forgets.

numba's cache knows the numbers of :mod:`kinds` as they were when this file was compiled (see :mod:`drag`).
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from fakes.plant.hidden.kinds import DIFFERENCE, HEAT, LOADED, NUMBER

_FIRST, _LAST = NUMBER["lag"], NUMBER["copper"]
_LAG, _TWICE, _HOUSING, _ROOM, _WAVE = (
    NUMBER["lag"],
    NUMBER["lag_twice"],
    NUMBER["housing"],
    NUMBER["room"],
    NUMBER["room_wave"],
)
_FAN, _LATENT, _COPPER = NUMBER["fan"], NUMBER["latent"], NUMBER["copper"]
_DELAY, _ZERO, _GAIN, _CURVED, _GAUGE = (
    NUMBER["delay"],
    NUMBER["zero_warm"],
    NUMBER["gain"],
    NUMBER["curved"],
    NUMBER["lagging_gauge"],
)
LONGEST = 12
"""cycles that the torque channel can be late"""


@njit(cache=True, error_model="numpy")
def aim_hidden_heat(hidden: Any, p: Any, s: Any) -> None:
    """Change surroundings and cooling, at the slow rate; the difference made is kept in the memory's place 1 (1/s)."""
    kinds, parameters, memory, _shown = hidden
    time = s.cycle * p.cycle_time
    for i in range(kinds.shape[0]):
        q, m = parameters[i], memory[i]
        if kinds[i] == _ROOM or kinds[i] == _WAVE:
            warmer = q[0] * time / 3600.0 if kinds[i] == _ROOM else q[0] * math.sin(2.0 * math.pi * time / q[1])
            s.surroundings += warmer
            m[1] = warmer
        elif kinds[i] == _FAN:
            m[1] = q[0] * abs(s.te_velocity * p.ratio / 100.0) ** q[1]
            s.cooling += m[1]


@njit(cache=True, error_model="numpy")
def _temperature_gain(kind: int, q: Any, m: Any, p: Any, s: Any, now: Any, change: float) -> tuple[float, float]:
    """Return K by which an effect changes the lubricant in a cycle: in addition to ``change``, and as a part of it."""
    step = p.cycle_time
    if kind == _HOUSING:
        if m[3] == 0.0:
            m[2], m[3] = s.temperature, 1.0
        gap = s.temperature - m[2]
        m[2] += step * gap / q[1]
        return -q[0] * gap * step, 0.0
    if kind == _LATENT:
        held = q[0] / p.heat_capacity * math.exp(-(((s.temperature - q[1]) / q[2]) ** 2))
        return change * (1.0 / (1.0 + held) - 1.0), 0.0
    if kind == _COPPER:
        return q[0] * (now.load_torque / 1000.0) ** 2 / p.heat_capacity * step, 0.0
    if kind == _FAN:
        return 0.0, -m[1] * (s.temperature - s.surroundings) * step
    return 0.0, s.cooling * m[1] * step


@njit(cache=True, error_model="numpy")
def warm_more(hidden: Any, p: Any, s: Any, now: Any, change: float) -> None:
    """Step hidden heat by a cycle in which the lubricant warmed by ``change`` (K) of itself."""
    kinds, parameters, memory, shown = hidden
    base = p.cycle_time / (p.heat_resistance * p.heat_capacity)
    for i in range(kinds.shape[0]):
        kind = kinds[i]
        if kind < _FIRST or kind > _LAST:
            continue
        q, m = parameters[i], memory[i]
        if kind in (_LAG, _TWICE):
            if m[3] == 0.0:
                m[1], m[2], m[3] = s.temperature, s.temperature, 1.0
            m[1] += p.cycle_time / q[0] * (s.temperature - m[1])
            m[2] = m[1] if kind == _LAG else m[2] + p.cycle_time / q[1] * (m[1] - m[2])
            s.sensed_temperature = m[2]
            shown[i, HEAT] = m[2] - s.temperature
            continue
        beyond, within = _temperature_gain(kind, q, m, p, s, now, change)
        s.temperature += beyond
        m[DIFFERENCE] += beyond + within - base * m[DIFFERENCE]
        shown[i, HEAT] = m[DIFFERENCE]


@njit(cache=True, error_model="numpy")
def sense(hidden: Any, s: Any, torque: float) -> float:
    """Return what the torque sensor makes of ``torque`` (N·m), noise apart."""
    kinds, parameters, memory, shown = hidden
    reading = torque
    for i in range(kinds.shape[0]):
        kind = kinds[i]
        if kind < _DELAY or kind > _GAUGE:
            continue
        q, m = parameters[i], memory[i]
        if kind == _DELAY:
            # a ring of the last cycles; all of it is filled at the first
            if m[LONGEST + 1] == 0.0:
                m[: LONGEST + 1] = torque
                m[LONGEST + 1] = 1.0
            place = s.cycle % (LONGEST + 1)
            m[place] = torque
            off = m[(place - int(q[0])) % (LONGEST + 1)] - torque
        elif kind == _ZERO:
            off = q[0] * (s.temperature - 25.0)
        elif kind == _GAIN:
            off = q[0] * torque
        elif kind == _CURVED:
            off = q[0] * (torque / 1000.0) ** 2
        else:
            change = torque - m[1]
            m[1] = torque
            way = math.copysign(1.0, change)
            m[0] = way + (m[0] - way) * math.exp(-abs(change) / q[1])
            off = -q[0] * m[0]
        shown[i, LOADED] = off
        reading += off
    return float(reading)
