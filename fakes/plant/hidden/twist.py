"""Hidden compliance: twist beyond that of the linear spring, driven by the torque in it.

Each is a contact with a film of its own: its twist follows what the torque wants within milliseconds, which keeps the
stiff loop of spring and contact stable at the drives' tick. A twist goes with the torque and behind it: one that went
before it would drive the shafts with energy from nowhere.

numba's cache knows the numbers of :mod:`kinds` as they were when this file was compiled (see :mod:`drag`).
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from fakes.plant.hidden.kinds import NUMBER, TE

FIRST, LAST = NUMBER["lost_arctan"], NUMBER["mullins"]
_ARCTAN, _ROOT, _CUBE, _BEYOND = (
    NUMBER["lost_arctan"],
    NUMBER["lost_root"],
    NUMBER["hardening"],
    NUMBER["second_spring"],
)
_PLAYS, _BOUC_WEN = NUMBER["play_pair"], NUMBER["bouc_wen"]
_SQUEEZE, _MULLINS = NUMBER["squeeze"], NUMBER["mullins"]
_HARD = 1150.0
"""N·m, up to which a spring that hardens still gives way"""
_TIME = 2e-3
"""time in which a contact's film lets it follow, s"""


@njit(cache=True, error_model="numpy")
def _play(state: float, drive: float, half_width: float) -> float:
    """Return the play operator: it stands until the drive has left it by ``half_width``."""
    return float(min(max(state, drive - half_width), drive + half_width))


@njit(cache=True, error_model="numpy")
def _wanted_twist(kind: int, q: Any, m: Any, torque: float) -> float:
    """Return the twist (rad) in equilibrium with ``torque``; m[1], m[2] are the states of the play."""
    if kind == _ARCTAN:
        return float(q[0] * math.atan(torque / q[1]) * 2.0 / math.pi)
    if kind == _ROOT:
        return float(q[0] * torque / math.sqrt(torque * torque + q[1] * q[1]))
    if kind == _CUBE:
        # one that hardens is soft to begin with
        soft = 3.0 * max(-q[0], 0.0) * (_HARD / q[1]) ** 2
        return float(q[0] * (torque / q[1]) ** 3 + soft * torque / q[1])
    if kind == _BEYOND:
        return float(q[0] * math.copysign(max(abs(torque) - q[1], 0.0), torque) / 1000.0)
    if kind == _PLAYS:
        m[1], m[2] = _play(m[1], torque, q[1]), _play(m[2], torque, q[2])
        # springs behind the plays: their mean is a compliance like any other
        return float(q[0] * (0.6 * m[1] / q[1] + 0.4 * m[2] / q[2]))
    if kind == _BOUC_WEN:
        change = torque - m[1]
        m[1] = torque
        way = math.copysign(1.0, change)
        m[2] = way + (m[2] - way) * math.exp(-abs(change) / q[1])
        # the twist of the spring less what it lacks of it: it holds until the friction gives way
        return float(q[0] * (torque / q[1] - m[2]))
    # _MULLINS: m[1] is the largest torque there ever was
    m[1] = max(m[1], abs(torque))
    return float(q[0] * torque / 1000.0 * (1.0 - math.exp(-m[1] / q[1])))


@njit(cache=True, error_model="numpy")
def twist(hidden: Any, s: Any, now: Any, step: float) -> None:
    """Advance every contact by ``step`` (s); m[0] is its twist, taken off the transmission error."""
    kinds, parameters, memory, shown = hidden
    for i in range(kinds.shape[0]):
        kind = kinds[i]
        if kind < FIRST or kind > LAST:
            continue
        q, m = parameters[i], memory[i]
        before = m[0]
        if kind == _SQUEEZE:
            # oil leaves the gap at a rate in proportion to the torque, slower the thinner it is cold
            rate = q[1] * s.torque * math.exp(0.03 * (s.temperature - 30.0))
            m[0] = min(max(m[0] + step * rate, -q[0]), q[0])
        else:
            m[0] += step / _TIME * (_wanted_twist(kind, q, m, s.torque) - m[0])
        now.te_value -= m[0] - before
        shown[i, TE] = -m[0]


@njit(cache=True, error_model="numpy")
def standing(hidden: Any, now: Any) -> None:
    """Take the twist there is off the transmission error, at a cycle's begin."""
    kinds, _parameters, memory, _shown = hidden
    for i in range(kinds.shape[0]):
        if FIRST <= kinds[i] <= LAST:
            now.te_value -= memory[i, 0]
