"""The instant of the bus cycle for which a drive reports its torque: unknown, so it counts as an uncertainty of J.

The set speed of a ramp comes in steps, one a bus cycle, and the drive's loop answers each: its torque leaps and falls
until the next step. A drive reports one instant of that, the equation takes the mean. The difference is in proportion
to the acceleration, in every ramp, so no recording at the bus rate separates it from an inertia.

How far it can go the recordings do say. Behind the end of a ramp no further step comes, and the torque goes on falling
as it fell within each cycle: by a share s of the ramp's own torque from row to row. The instant may lie anywhere in the
cycle, so the mean is off by up to ±s/2 of J: a rectangular distribution of standard deviation s/√12 (GUM, 4.3.7).
It is the same in every recording of a drive: two runs on one bench share it, so comparisons leave it out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.identification.statistics.regression import LinearFit
from bench.recording import Recording
from bench.simulation import Term

FloatArray = NDArray[np.float64]

KEY = "systematic"
"""Key of a term in a simulation file: symbol → standard deviation that all recordings of a bench share."""
CHANNELS = ("motor_velocity_setpoint", "motor_torque", "load_torque")
LOOKED_AT = 48
LOOKED_S = 5.0
"""Ramps are looked for in the first seconds of a recording."""
BEFORE, AFTER = 60, 150
"""Rows of ramp before the corner, and rows of constant set speed behind it, that are averaged over recordings."""
MIN_CORNERS = 8
HIGH, LOW = 0.9, 0.3
"""Shares of the ramp's torque between which the fall is taken."""


def _corner(recording: Recording) -> FloatArray | None:
    """Motor torque (BEFORE + AFTER,) about the end of the first ramp, in the ramp's direction; None without one."""
    if recording.gearbox.ratio is None or any(name not in recording.specs for name in CHANNELS):
        return None
    stop = min(recording.size, round(LOOKED_S * recording.sample_rate))
    channels = recording.read_si(list(CHANNELS), 0, stop)
    speed, torque, load = (channels[name] for name in CHANNELS)
    # the load's own torque swings, with the load motor's ripple, by a good part of what a ramp takes
    torque = torque - load / recording.gearbox.ratio
    if not (np.isfinite(speed).all() and np.isfinite(torque).all()) or speed.size < BEFORE + AFTER:
        return None
    step = np.diff(speed)
    ramped = np.abs(step) > 0.5 * np.abs(step).max(initial=0.0)
    for end in np.flatnonzero(ramped[:-1] & ~ramped[1:]) + 1:
        before, after = ramped[max(end - BEFORE, 0) : end], ramped[end : end + AFTER]
        if before.size == BEFORE and after.size == AFTER and before.all() and not after.any():
            return np.asarray(np.sign(step[end - 1]) * torque[end - BEFORE : end + AFTER])
    return None


def fall_per_row(recordings: Sequence[Recording]) -> float | None:
    """Share of a ramp's torque by which the torque falls from row to row behind it; None where no ramp shows it."""
    moved = [r for r in recordings if r.setpoint.velocity != 0.0]
    if len(moved) > LOOKED_AT:
        moved = [moved[i] for i in np.linspace(0, len(moved) - 1, LOOKED_AT).astype(int)]
    corners = [c for r in moved if (c := _corner(r)) is not None]
    if len(corners) < MIN_CORNERS:
        return None
    mean = np.mean(corners, axis=0)
    at_last = mean[-AFTER // 3 :].mean()
    height = mean[: BEFORE - 2].mean() - at_last
    if height <= 0.0:
        return None
    falling = (mean[BEFORE - 1 :] - at_last) / height
    low = int(np.argmax(falling < LOW))
    if low == 0:
        return None
    # the last row above: the first one below may be noise
    high = int(np.flatnonzero(falling[:low] > HIGH)[-1]) if (falling[:low] > HIGH).any() else 0
    rows = np.arange(high, low + 1)
    return float(-np.polyfit(rows, falling[rows], 1)[0])


def systematic(recordings: Sequence[Recording], friction: LinearFit) -> dict[str, float]:
    """Standard deviation of J that the unknown instant makes; empty without J, or where no ramp shows it."""
    share = fall_per_row(recordings) if "J" in friction.values else None
    return {} if share is None else {"J": abs(friction.values["J"]) * share / float(np.sqrt(12.0))}


def systematic_entry(values: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """Return what a term says of its shared standard deviations; nothing where there are none."""
    return {KEY: dict(values)} if values else {}


def systematic_std(term: Term | None, symbol: str) -> float:
    """Shared standard deviation of a parameter; 0 where the file says nothing."""
    stated: Any = term.extra.get(KEY) if term is not None else None
    value = stated.get(symbol) if isinstance(stated, dict) else None
    return float(value) if isinstance(value, int | float) and value > 0 else 0.0
