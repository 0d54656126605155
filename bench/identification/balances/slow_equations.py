"""Friction at the input, by linear least squares (bench-physics, equation 2).

    τ_m − τ/u = d·f_c + f_v·ω_m + f_vT·ω_m·(T − 25 °C) + d·f_l·|τ|/u + J·ω̇_m + τ_0

Rows are the 50 ms blocks of all recordings, in motion only. τ is the recorded channel, so the torque sensor's zero is
in it: τ_0 is the drive's constant less z_0/u. Accelerations count outside steady segments only: inside, they are the
encoder's noise. Heating recordings run several times as fast as what the model is for: few as they are, their leverage
would decide f_v and f_vT, so they count only where the others do not determine a symbol.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bench.identification.samples.motion import SPEED_LEVEL, TORQUE_LEVEL, accelerating, levels, moving, set_speed
from bench.identification.samples.reduction import Reduction
from bench.identification.samples.rows import Rows, join
from bench.identification.statistics.regression import LinearFit, regress, sentences, stack

FloatArray = NDArray[np.float64]

REFERENCE_TEMPERATURE = 25.0
HEATING = "heating"
MIN_TEMPERATURE_SPREAD = 2.0

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


def friction_rows(reductions: Sequence[Reduction]) -> Rows:
    """Collect the rows of recordings that measured motor torque."""
    parts = []
    steady = []
    for i, r in enumerate(reductions):
        b, mask = r.blocks, moving(r.blocks) & np.isfinite(r.blocks.motor_torque)
        if r.limited is None and mask.any():
            torque, size = b.load_torque[mask] / r.ratio, b.load_size[mask] / r.ratio
            group = np.full(int(mask.sum()), i)
            speed, rate = set_speed(b.motor_velocity[mask], b.steady[mask]), b.acceleration[mask]
            measured, heat = b.motor_torque[mask], b.temperature[mask]
            parts.append(Rows(group, b.direction[mask], speed, rate, measured, torque, heat, size))
            steady.append(b.steady[mask])
    blocks = join(parts)
    blocks = replace(blocks, acceleration=accelerating(blocks.acceleration, stack(steady)))
    limited = [replace(r.limited, group=r.limited.group + i) for i, r in enumerate(reductions) if r.limited]
    return join([blocks, *limited])


def friction_of(reductions: Sequence[Reduction]) -> tuple[LinearFit, list[str]]:
    """Fit the input's torque balance without heating recordings, or with them where more is determined so."""
    slow = [r for r in reductions if r.kind != HEATING]
    fit, sentences = identify_friction(friction_rows(slow))
    if fit.undetermined and len(slow) < len(reductions):
        with_heating, more = identify_friction(friction_rows(reductions))
        if len(with_heating.values) > len(fit.values):
            return with_heating, more
    return fit, sentences


def shared_levels(rows: Rows, torque: FloatArray, good: NDArray[np.bool_]) -> tuple[NDArray[np.int64], ...]:
    """Levels over which the rows that are ``good`` share an error: those of one speed, and those of one torque.

    None where no row accelerates: then nothing says which rows are steady.
    """
    if not rows.acceleration.any():
        return ()
    steady = rows.acceleration[good] == 0.0
    direction, group = rows.direction[good], rows.group[good]
    speed = np.log(np.maximum(np.abs(rows.omega[good]), 1e-9))
    step = TORQUE_LEVEL * max(float(np.ptp(torque[good])), 1e-12)
    by_speed = levels(speed, direction, group, steady, SPEED_LEVEL)
    return by_speed, levels(torque[good], direction, group, steady, step)


def identify_friction(rows: Rows) -> tuple[LinearFit, list[str]]:
    """Fit the torque balance of the input; ``rows.torque`` is τ/u. Returns the fit and what is not determined."""
    direction = rows.direction
    lines: list[str] = []
    if rows.omega.size == 0:
        nothing = LinearFit({}, {}, tuple(FRICTION_MEANING), float("nan"), 0)
        return nothing, ["Friction is not identified: no recording has motor_torque in motion."]
    good = np.ones(rows.omega.size, dtype=bool)
    torque, size = rows.torque, rows.size
    measured = np.isfinite(torque)
    if not measured.any():
        lines.append("load_torque is missing: it is taken as 0 in the torque balance, f_l is not determined.")
        torque = size = np.zeros_like(rows.omega)
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
        "f_l": direction * size,
        "f_vT": rows.omega * warm,
    }
    shared = shared_levels(rows, torque, good)
    target = (rows.motor_torque - torque)[good]
    fit = regress({k: v[good] for k, v in columns.items()}, target, rows.group[good], (), shared)
    return fit, lines + sentences(fit, FRICTION_MEANING, FRICTION_REASONS)
