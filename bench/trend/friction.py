"""Friction at the speeds and temperatures a campaign measured without load, each with its own standard deviation.

The torque balance is linear, so it is fitted once more a point with the friction there in place of f_c: with
F = f_c + f_v·ω₀ + f_vT·ω₀·(T₀ − 25 °C) the columns of f_v and f_vT become ω − d·ω₀ and ω·(T − 25) − d·ω₀·(T₀ − 25). The
jackknife over recordings then gives the standard deviation of F itself, with all its parts' correlation in it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bench.identification.balances.slow_equations import (
    HEATING,
    REFERENCE_TEMPERATURE,
    friction_rows,
    shared_levels,
)
from bench.identification.samples.reduction import Reduction
from bench.identification.samples.rows import Rows
from bench.identification.statistics.regression import regress
from bench.trend.quantities import SPEED_MARGIN, TORQUE_MARGIN_NM, Value

FloatArray = NDArray[np.float64]

LEAST_SHARE = 0.002
"""Share of the samples without load at a constant speed that a speed and a temperature have at least."""


def reference_friction(reductions: Sequence[Reduction], ratio: float) -> dict[tuple[float, float], Value]:
    """Return friction without load in N·m at the motor by (speed °/s of the load side, temperature in whole °C).

    Only points that were measured are there: without load, at a constant speed, at that temperature. Heating is left
    out; there are none where a temperature is missing.
    """
    slow = [r for r in reductions if r.kind != HEATING and not r.validation]
    rows = friction_rows(slow)
    good = np.isfinite(rows.torque) & np.isfinite(rows.temperature) & np.isfinite(rows.motor_torque)
    # ramps pass through speeds that nobody measured at
    even = good & (rows.acceleration == 0.0) & (rows.size * ratio <= TORQUE_MARGIN_NM)
    speed = np.degrees(np.abs(rows.omega[even])) / ratio
    found = {}
    for at, temperature in _measured_points(speed, rows.temperature[even]):
        value = _friction_at(rows, good, float(np.radians(at)) * ratio, temperature, ratio)
        if value is not None:
            found[at, temperature] = value
    return found


def _measured_points(speed: FloatArray, temperature: FloatArray) -> list[tuple[float, float]]:
    """Round speeds (°/s) and whole temperatures (°C) at which samples (n,) of both are, in order."""
    moving = speed > 0.0
    speed, temperature = speed[moving], temperature[moving]
    if not speed.size:
        return []
    rounded = _round_speeds(speed)
    near = np.maximum(speed / rounded, rounded / speed) <= SPEED_MARGIN
    pairs = np.stack((rounded[near], np.round(temperature[near])), axis=1)
    points, counts = np.unique(pairs, axis=0, return_counts=True)
    return [(float(at), float(warm)) for at, warm in points[counts >= LEAST_SHARE * speed.size]]


def _round_speeds(speed: FloatArray) -> FloatArray:
    """The nearest of 1, 1.05, 1.1 … 9.9, 9.95 times a power of ten: what somebody asks a bench for."""
    power = 10.0 ** np.floor(np.log10(speed))
    return np.asarray(np.round(20.0 * speed / power) * power / 20.0)


def _friction_at(rows: Rows, good: NDArray[np.bool_], omega: float, temperature: float, ratio: float) -> Value | None:
    """Friction at a speed (rad/s of the motor) and temperature (°C) from the rows that are good."""
    d, warm = rows.direction, rows.temperature - REFERENCE_TEMPERATURE
    columns = {
        "F": d,
        "f_v": rows.omega - d * omega,
        "tau_0": np.ones_like(d),
        "J": rows.acceleration,
        "f_l": d * rows.size,
        "f_vT": rows.omega * warm - d * omega * (temperature - REFERENCE_TEMPERATURE),
    }
    target = (rows.motor_torque - rows.torque)[good]
    group, shared = rows.group[good], shared_levels(rows, rows.torque, good)
    fit = regress({name: column[good] for name, column in columns.items()}, target, group, (), shared)
    if "F" not in fit.values:
        return None
    if "f_l" in fit.undetermined and float(np.median(rows.size[good])) * ratio > TORQUE_MARGIN_NM:
        # every recording had the same load: what it makes cannot be separated from the friction without it
        return None
    return Value(fit.values["F"], fit.std["F"], fit.freedom["F"])
