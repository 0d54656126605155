"""Friction at reference points, each with its own standard deviation.

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
from bench.trend.quantities import SPEED_MARGIN, TEMPERATURE_MARGIN_K, TORQUE_MARGIN_NM, Value

FloatArray = NDArray[np.float64]

SPEEDS_DEG_S = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
"""Of the load side, degrees a second."""
TEMPERATURES_DEGC = (20.0, 30.0, 40.0, 50.0)


def reference_friction(reductions: Sequence[Reduction], ratio: float) -> dict[tuple[float, float], Value]:
    """Return friction without load in N·m at the motor by (speed °/s of the load side, temperature °C).

    Only points within what recordings measured are there, heating left out; none where a temperature is missing.
    """
    slow = [r for r in reductions if r.kind != HEATING and not r.validation]
    rows = friction_rows(slow)
    good = np.isfinite(rows.torque) & np.isfinite(rows.temperature) & np.isfinite(rows.motor_torque)
    if not good.any():
        return {}
    # ramps pass through speeds that nobody measured at
    even = good & (rows.acceleration == 0.0)
    speed = np.degrees(np.abs(rows.omega[even if even.any() else good])) / ratio
    least, most = np.percentile(speed, (2.0, 98.0))
    cold, warm = np.percentile(rows.temperature[good], (2.0, 98.0))
    found = {}
    for at in SPEEDS_DEG_S:
        for temperature in TEMPERATURES_DEGC:
            within = least / SPEED_MARGIN <= at <= most * SPEED_MARGIN
            if within and cold - TEMPERATURE_MARGIN_K <= temperature <= warm + TEMPERATURE_MARGIN_K:
                omega = float(np.radians(at)) * ratio
                value = _friction_at(rows, good, omega, temperature, ratio)
                if value is not None:
                    found[at, temperature] = value
    return found


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
