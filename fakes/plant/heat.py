"""Heat balance of the gearbox: loss in, cooling to the surroundings, and further ways where the plant has them.

dT/dt = P/C − (1/(R·C) + h·(|ω_m|/100 rad/s)^n)·(T − T_amb(t)) − k_h·(T − T_h),    τ_h·dT_h/dt = T − T_h
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit


@njit(cache=True, error_model="numpy")
def aim_heat(p: Any, s: Any) -> None:
    """Evaluate what changes slowly: the surroundings and the rate of cooling."""
    time = s.cycle * p.cycle_time
    s.surroundings = p.ambient + (p.ambient_rate + p.ambient_curvature * time) * time
    if p.ambient_period > 0.0:
        phase = 2.0 * math.pi * time / p.ambient_period
        s.surroundings += p.ambient_cosine * math.cos(phase) + p.ambient_sine * math.sin(phase)
    if p.ambient_settling > 0.0 and time > p.ambient_begin:
        s.surroundings += p.ambient_change * (1.0 - math.exp((p.ambient_begin - time) / p.ambient_settling))
    s.cooling = 1.0 / (p.heat_resistance * p.heat_capacity)
    if p.speed_cooling > 0.0:
        s.cooling += p.speed_cooling * abs(s.te_velocity * p.ratio / 100.0) ** p.speed_exponent


@njit(cache=True, error_model="numpy")
def warm(p: Any, s: Any, heat: float) -> None:
    """Step the temperatures of lubricant, housing and PT100 by a cycle in which ``heat`` (J) came in."""
    change = heat / p.heat_capacity - s.cooling * (s.temperature - s.surroundings) * p.cycle_time
    if p.housing_rate > 0.0:
        difference = s.temperature - s.housing
        change -= p.housing_rate * difference * p.cycle_time
        s.housing += difference * p.cycle_time / p.housing_time
    s.temperature += change
    s.sensed_temperature += p.lubricant_share * (s.temperature - s.sensed_temperature)
