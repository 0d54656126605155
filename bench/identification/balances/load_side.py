"""The load side's torque balance (bench-physics, equation 4), with what is known to disturb it as nuisance.

    load_torque − load_motor_torque = d·f_b + J_L·q̈ + z_0 + z(level) + Σ_f [s_f·sin(f·q) + c_f·cos(f·q)]

The load motor's ripple is many times the inertia's torque, so its orders are fitted beside. What a drive reports of its
torque is quantised, once inside and once for the bus: the mean of the two depends on the level, by a part of a count,
and is the same in every recording of that level. So each level has an offset of its own; z_0 is their mean, and as
uncertain as they scatter. Rows in which the torque is being ramped belong to no level and are left out. An encoder that
is fine enough sees the accelerations that the transmission error makes at steady speed, too: they count as those of
ramps do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bench.identification.samples.blocks import BLOCK_S, Blocks
from bench.identification.samples.motion import accelerating, moving
from bench.identification.samples.reduction import Reduction
from bench.identification.statistics.regression import LinearFit, regress, sentences, stack

FloatArray = NDArray[np.float64]

LEVEL_STEP = 5.0
"""N·m; levels closer than this count as one. Between two rows a ramp moves the torque further than this."""
MIN_LEVEL_ROWS = 20
ERRS_BY = 0.003
"""Share of an acceleration's mean square that may be noise of the encoder: J_L is drawn towards 0 by as much."""
LOAD_MEANING = {"z_0": "zero of the torque sensor", "f_b": "bearing friction", "J_L": "load inertia"}
LOAD_REASONS = {
    "z_0": "it takes motion in both directions",
    "f_b": "it takes motion in both directions",
    "J_L": "it takes segments in which the load accelerates",
}
LOAD_UNITS = {"z_0": "N*m", "f_b": "N*m", "J_L": "kg*m^2"}
_LEVEL, _RIPPLE = "level ", "ripple "


def ripple_columns(blocks: Blocks, orders: Sequence[float]) -> dict[str, FloatArray]:
    """Columns (n,) of each order's sine and cosine at the load angle, averaged as the blocks are.

    Under a triangle of half-width Δ, exp(i·f·q) with q = q_c + q̇·t + ½·q̈·t² becomes exp(i·f·q_c)·(S(w) − ½i·f·q̈·S″(w)),
    w = f·q̇, S(w) = sinc²(½wΔ), to first order in q̈; the block's mean angle is q_c + ½·q̈·Δ²/6.
    """
    if not orders or blocks.size < 2 or not np.isfinite(blocks.load_angle).all():
        return {}
    width = float(np.median(np.diff(blocks.time)))
    rate = np.where(np.isfinite(blocks.load_acceleration), blocks.load_acceleration, 0.0)
    centre = blocks.load_angle - 0.5 * rate * width**2 / 6.0

    def shape(w: FloatArray) -> FloatArray:
        return np.asarray(np.sinc(0.5 * w * width / np.pi) ** 2)

    out: dict[str, FloatArray] = {}
    step = 0.02 / width
    for order in orders:
        w = order * blocks.load_velocity
        curvature = (shape(w + step) - 2.0 * shape(w) + shape(w - step)) / step**2
        wave = np.exp(1j * order * centre) * (shape(w) - 0.5j * order * rate * curvature)
        out[f"{_RIPPLE}{order:g} s"], out[f"{_RIPPLE}{order:g} c"] = wave.imag, wave.real
    return out


def _acceleration(acceleration: FloatArray, steady: FloatArray, count: float) -> FloatArray:
    """Acceleration (n,) that counts: where it stands out, or everywhere if one ``count`` (rad) makes little of it."""
    even = acceleration[(steady > 0) & np.isfinite(acceleration)]
    # one count of noise at each of three instants, weights 1, −2 and 1
    noise = 6.0 * (count / BLOCK_S**2) ** 2
    if even.size and noise <= ERRS_BY * float(np.mean(even**2)):
        return np.where(np.isfinite(acceleration), acceleration, 0.0)
    return accelerating(acceleration, steady)


def _levels(torque: FloatArray, group: NDArray[np.int64]) -> NDArray[np.int64]:
    """Number of the level each row (n,) stands at, −1 where the torque is on its way between two."""
    step = np.abs(np.diff(torque))
    step[np.diff(group) != 0] = 0.0
    ramped = np.concatenate([[False], step > LEVEL_STEP]) | np.concatenate([step > LEVEL_STEP, [False]])
    number = np.rint(torque / LEVEL_STEP).astype(np.int64)
    known, index, count = np.unique(number[~ramped], return_inverse=True, return_counts=True)
    out = np.full(torque.size, -1, dtype=np.int64)
    kept = np.where(count >= MIN_LEVEL_ROWS, np.arange(known.size), -1)
    out[~ramped] = kept[index]
    return out


def identify_load_side(reductions: Sequence[Reduction], ripple: Sequence[float] = ()) -> tuple[LinearFit, list[str]]:
    """Fit the load side's torque balance; ``ripple`` are the load motor's orders. Returns fit and what is left open."""
    use: list[tuple[int, Blocks, NDArray[np.bool_]]] = []
    for i, r in enumerate(reductions):
        mask = moving(r.blocks) & np.isfinite(r.blocks.load_torque) & np.isfinite(r.blocks.load_motor_torque)
        if mask.any():
            use.append((i, r.blocks, mask))
    if not use:
        nothing = LinearFit({}, {}, tuple(LOAD_MEANING), float("nan"), 0)
        return nothing, ["The load side is not identified: no recording has both load torques in motion."]
    group = np.concatenate([np.full(int(m.sum()), i) for i, _, m in use])
    waves = [ripple_columns(b, ripple) for _, b, _ in use]
    shared = set.intersection(*(set(w) for w in waves))
    columns = {
        "f_b": stack([b.direction[m] for _, b, m in use]),
        "J_L": _acceleration(
            stack([b.load_acceleration[m] for _, b, m in use]),
            stack([b.steady[m] for _, b, m in use]),
            max(reductions[i].load_count for i, _, _ in use),
        ),
    } | {
        name: stack([w[name][m] for w, (_, _, m) in zip(waves, use, strict=True)])
        for name in waves[0]
        if name in shared
    }
    target = stack([(b.load_torque - b.load_motor_torque)[m] for _, b, m in use])
    level = _levels(stack([b.load_motor_torque[m] for _, b, m in use]), group)
    fit = _by_level(columns, target, group, level) or _plain(columns, target, group)
    return fit, sentences(fit, LOAD_MEANING, LOAD_REASONS)


def _plain(columns: dict[str, FloatArray], target: FloatArray, group: NDArray[np.int64]) -> LinearFit:
    """One offset for all rows: where levels and directions cannot be separated."""
    return regress(
        {"z_0": np.ones_like(target), **columns}, target, group, [n for n in columns if n.startswith(_RIPPLE)]
    )


def _by_level(
    columns: dict[str, FloatArray], target: FloatArray, group: NDArray[np.int64], level: NDArray[np.int64]
) -> LinearFit | None:
    """An offset for each level; None with fewer than two levels, or where bearing friction is lost by it."""
    known = np.unique(level[level >= 0])
    if known.size < 2:
        return None
    at = level >= 0
    offsets = {f"{_LEVEL}{n}": (level[at] == n).astype(np.float64) for n in known}
    rows = {name: values[at] for name, values in columns.items()}
    # offsets first: of two columns that are alike the later one is given up, and then the friction is lost
    fit = regress(offsets | rows, target[at], group[at], [n for n in rows if n.startswith(_RIPPLE)])
    if "f_b" in fit.undetermined or any(name.startswith(_LEVEL) for name in fit.undetermined):
        return None
    found = np.asarray([fit.values[name] for name in offsets])
    drop = {name: value for name, value in fit.values.items() if name not in offsets}
    return replace(
        fit,
        values={"z_0": float(found.mean())} | drop,
        std={"z_0": float(found.std(ddof=1) / np.sqrt(found.size))} | {name: fit.std[name] for name in drop},
        freedom={"z_0": float(found.size - 1)} | {name: fit.freedom[name] for name in drop},
    )
