"""Friction at the input and forces at the load side, by linear least squares (bench-physics, equations 2 and 4).

    τ_m − τ/u = d·f_c + f_v·ω_m + f_vT·ω_m·(T − 25 °C) + d·f_l·|τ|/u + J·ω̇_m + τ_0
    load_torque − load_motor_torque = d·f_b + J_L·q̈ + z_0

Rows are the 50 ms blocks of all recordings, in motion only. The torque sensor's zero z_0 comes from the second equation
and is taken off τ in the first. Accelerations count outside steady segments only: inside, they are the encoder's noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bench.identification.reduction import Reduction
from bench.identification.regression import LinearFit, regress, sentences, stack
from bench.identification.rows import Rows, join

FloatArray = NDArray[np.float64]

REFERENCE_TEMPERATURE = 25.0
MIN_TEMPERATURE_SPREAD = 2.0
MIN_ACCELERATED_ROWS = 12

FRICTION_MEANING = {
    "f_c": "Coulomb friction",
    "f_v": "viscous friction",
    "f_vT": "change of viscous friction with temperature",
    "f_l": "friction that grows with load",
    "J": "inertia at the motor shaft",
    "tau_0": "constant torque",
}
FRICTION_REASONS = {
    "f_c": "it takes motion at several speeds",
    "f_v": "it takes several speeds",
    "f_vT": f"it takes lubricant temperatures more than {MIN_TEMPERATURE_SPREAD:g} K apart at several speeds",
    "f_l": "it takes several load torques",
    "J": "it takes segments in which the motor accelerates",
    "tau_0": "it takes motion in both directions",
}
FRICTION_UNITS = {
    "f_c": "N*m", "f_v": "N*m*s/rad", "f_vT": "N*m*s/(rad*K)", "f_l": "1", "J": "kg*m^2", "tau_0": "N*m",
}  # fmt: skip
LOAD_MEANING = {"z_0": "zero of the torque sensor", "f_b": "bearing friction", "J_L": "load inertia"}
LOAD_REASONS = {
    "z_0": "it takes motion in both directions",
    "f_b": "it takes motion in both directions",
    "J_L": "it takes segments in which the load accelerates",
}
LOAD_UNITS = {"z_0": "N*m", "f_b": "N*m", "J_L": "kg*m^2"}


def _moving(r: Reduction) -> NDArray[np.bool_]:
    """Rows in motion; those beside standstill are left out, where friction is whatever holds the shaft."""
    b, d = r.blocks, r.blocks.direction
    same = np.zeros(d.size, dtype=bool)
    if d.size > 2:
        same[1:-1] = (d[1:-1] != 0) & (d[:-2] == d[1:-1]) & (d[2:] == d[1:-1])
    return np.asarray(same & (b.whole > 0))


def _accelerating(acceleration: FloatArray, steady: FloatArray) -> FloatArray:
    """Acceleration (n,) where it stands out of the encoder's noise, elsewhere 0; 0 throughout where too few rows do.

    Noise in a regressor would draw its coefficient towards 0.
    """
    moving = (steady == 0) & np.isfinite(acceleration)
    noise = float(np.median(np.abs(acceleration[steady > 0]))) if (steady > 0).any() else 0.0
    out = np.where(moving & (np.abs(acceleration) > 10.0 * noise), acceleration, 0.0)
    return out if np.count_nonzero(out) >= MIN_ACCELERATED_ROWS else np.zeros_like(out)


def friction_rows(reductions: Sequence[Reduction], torque_zero: float = 0.0) -> Rows:
    """Collect the rows of recordings that measured motor torque; ``torque_zero`` N·m is taken off the load torque."""
    parts = []
    steady = []
    for i, r in enumerate(reductions):
        b, mask = r.blocks, _moving(r) & np.isfinite(r.blocks.motor_torque)
        if r.limited is None and mask.any():
            torque = (b.load_torque[mask] - torque_zero) / r.ratio
            group = np.full(int(mask.sum()), i)
            speed, rate = b.motor_velocity[mask], b.acceleration[mask]
            parts.append(Rows(group, b.direction[mask], speed, rate, b.motor_torque[mask], torque, b.temperature[mask]))
            steady.append(b.steady[mask])
    blocks = join(parts)
    blocks = replace(blocks, acceleration=_accelerating(blocks.acceleration, stack(steady)))
    limited = [replace(r.limited, group=r.limited.group + i) for i, r in enumerate(reductions) if r.limited]
    return join([blocks, *limited])


def identify_friction(rows: Rows) -> tuple[LinearFit, list[str]]:
    """Fit the torque balance of the input; ``rows.torque`` is τ/u. Returns the fit and what is not determined."""
    direction = rows.direction
    said: list[str] = []
    if rows.omega.size == 0:
        nothing = LinearFit({}, {}, tuple(FRICTION_MEANING), float("nan"), 0)
        return nothing, ["Friction is not identified: no recording has motor_torque in motion."]
    good = np.ones(rows.omega.size, dtype=bool)
    torque = rows.torque
    measured = np.isfinite(torque)
    if not measured.any():
        said.append("load_torque is missing: it is taken as 0 in the torque balance, f_l is not determined.")
        torque = np.zeros_like(rows.omega)
    else:
        good &= measured
    warm = rows.temperature - REFERENCE_TEMPERATURE
    if not np.isfinite(warm[good]).all() or float(np.ptp(warm[good], axis=0)) < MIN_TEMPERATURE_SPREAD:
        warm = np.zeros_like(warm)
    columns = {
        "f_c": direction,
        "f_v": rows.omega,
        "tau_0": np.ones_like(rows.omega),
        "J": rows.acceleration,
        "f_l": direction * np.abs(torque),
        "f_vT": rows.omega * warm,
    }
    fit = regress({k: v[good] for k, v in columns.items()}, (rows.motor_torque - torque)[good], rows.group[good])
    return fit, said + sentences(fit, FRICTION_MEANING, FRICTION_REASONS)


def identify_load_side(reductions: Sequence[Reduction]) -> tuple[LinearFit, list[str]]:
    """Fit the load side's torque balance; returns the fit and what is not determined."""
    use = []
    for i, r in enumerate(reductions):
        mask = _moving(r) & np.isfinite(r.blocks.load_torque) & np.isfinite(r.blocks.load_motor_torque)
        if mask.any():
            use.append((i, r.blocks, mask))
    if not use:
        nothing = LinearFit({}, {}, tuple(LOAD_MEANING), float("nan"), 0)
        return nothing, ["The load side is not identified: no recording has both load torques in motion."]
    direction = stack([b.direction[m] for _, b, m in use])
    steady = stack([b.steady[m] for _, b, m in use])
    columns = {
        "z_0": np.ones_like(direction),
        "f_b": direction,
        "J_L": _accelerating(stack([b.load_acceleration[m] for _, b, m in use]), steady),
    }
    target = stack([(b.load_torque - b.load_motor_torque)[m] for _, b, m in use])
    fit = regress(columns, target, np.concatenate([np.full(int(m.sum()), i) for i, _, m in use]))
    return fit, sentences(fit, LOAD_MEANING, LOAD_REASONS)
