"""Strength of an effect: what is left of it after the nominal simulation has been refitted, in units of the noise.

The nominal simulation is linearised in its parameters and projected out of the effect's own contribution; what remains
is the excess. Strength is the RMS of the excess over its active samples (the smallest set that holds 95 % of its
energy, at least 2 % of all), so that a short pulse and a wave of the same height are of like strength.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fakes.concealed.campaign import Campaign, Signals
from fakes.concealed.effects.base import Effect, Floats, Run
from fakes.concealed.plant import LOAD_RIPPLE_ORDERS, ORDERS, RATIO

_RATE_HZ = 50.0
_STANDSTILL = 0.3  # rad/s at the motor: below, a bench stands (bench-physics, "Notation")
_MOST = 9000  # samples a direction in the projection of the transmission error


#: Columns of :attr:`Excess.states`.
STATES = ("velocity", "load_torque", "temperature", "direction")


@dataclass(slots=True)
class _Rows:
    """Samples of one recording: nominal regressors (n, p), the effect's contribution (n,), states (n, 4)."""

    regressors: NDArray[Any]
    excess: Floats
    states: Floats


@dataclass(slots=True)
class Excess:
    """What is left of the effects after the nominal's refit, at samples drawn from the whole campaign.

    Attributes:
        values: (M,) in the channel's unit. states: (M, 4), see :data:`STATES`. recording: (M,) its number.
        weight: (M,) how many samples each stands for.
    """

    values: Floats
    states: Floats
    recording: NDArray[np.int64]
    weight: Floats


def measure(campaign: Campaign, channel: str, rate_hz: float = _RATE_HZ) -> Floats:
    """Excess (M,) of a campaign's effects in one channel after the nominal's refit."""
    return excess_of(campaign, channel, rate_hz).values


def excess_of(campaign: Campaign, channel: str, rate_hz: float = _RATE_HZ) -> Excess:
    """The same with the states in which it stands."""
    numbered = enumerate(_rows(signals, channel) for signals in campaign.run(rate_hz, angle=False))
    rows = [(i, r) for i, r in numbered if r is not None]
    excess = np.concatenate([r.excess for _i, r in rows])
    table = np.concatenate([r.regressors for _i, r in rows])
    states = np.concatenate([r.states for _i, r in rows])
    recording = np.concatenate([np.full(r.excess.size, i) for i, r in rows])
    if channel != "transmission_error":
        return Excess(project(table, excess, expand=False)[0], states, recording, np.ones(excess.size))
    parts = []
    for side in (0.0, 1.0):
        picked = np.flatnonzero(table[:, -1] == side)
        if picked.size:
            left, chosen = project(table[picked], excess[picked])
            at = picked[chosen]
            parts.append((left, states[at], recording[at], np.full(at.size, picked.size / at.size)))
    return Excess(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def covered(campaign: Campaign, channel: str, rate_hz: float = _RATE_HZ) -> dict[str, tuple[float, float]]:
    """Smallest and largest speed, load and temperature at which a campaign has samples of a channel."""
    rows = (_rows(signals, channel) for signals in campaign.run(rate_hz, angle=False))
    states = np.concatenate([r.states for r in rows if r is not None])
    return {name: (float(states[:, at].min()), float(states[:, at].max())) for at, name in enumerate(STATES[:3])}


def strength(excess: Floats, noise_rms: float) -> float:
    """RMS of the excess over its active samples, over the noise."""
    square = np.sort(excess**2)[::-1]
    total = float(square.sum())
    if total == 0.0:
        return 0.0
    count = int(np.searchsorted(np.cumsum(square), 0.95 * total)) + 1
    count = max(count, int(0.02 * square.size), 1)
    return float(np.sqrt(square[:count].mean()) / noise_rms)


def calibrate(campaign: Campaign, effect: Effect, target: float, noise_rms: float) -> tuple[float, Excess]:
    """Set the effect's amplitude so that its strength alone meets the target.

    Returns the strength reached and the effect's excess at it.
    """
    alone = Campaign(campaign.plant, (effect,), campaign.points, campaign.seed)
    excess = excess_of(alone, effect.channels[0])
    for _ in range(5):
        strength_now = strength(excess.values, noise_rms)
        if strength_now <= 0.0 or abs(strength_now / target - 1.0) < 0.05:
            break
        effect.amplitude *= float(np.clip(target / strength_now, 0.05, 20.0))
        excess = excess_of(alone, effect.channels[0])
    return strength(excess.values, noise_rms), excess


def _rows(signals: Signals, channel: str) -> _Rows | None:
    if channel == "temperature":
        return _temperature_rows(signals)
    run = signals.run
    if channel == "transmission_error":
        if run.point.kind in ("heating", "cooling", "dwell"):
            return None
        every = 2
        x = np.clip(run.torque[::every], -1150.0, 1150.0) / 1000.0
        y = (np.abs(run.rate[::every])) / 0.17
        z = (run.temperature[::every] - 35.0) / 15.0
        table = np.column_stack((run.theta[::every], x, y, z, run.side[::every]))
        return _Rows(table, signals.added[channel][::every], _states(signals, slice(None, None, every)))
    # at rest friction has no direction: no torque is compared there
    moving = np.flatnonzero(np.abs(run.motor_rate) > _STANDSTILL)[::4]
    if not moving.size:
        return None
    sign, torque = run.sign[moving], run.torque[moving]
    if channel == "load_torque":
        table = np.column_stack((sign, run.acceleration[moving], np.ones(sign.size)))
    else:
        rate = run.motor_rate[moving]
        warm = rate * (run.temperature[moving] - 25.0)
        load = sign * np.abs(torque) / RATIO
        table = np.column_stack((sign, rate, warm, load, run.acceleration[moving], np.ones(sign.size)))
    added = _notched(run, moving, np.column_stack((table, signals.added[channel][moving])))
    return _Rows(added[:, :-1], added[:, -1], _states(signals, moving))


def _notched(run: Run, rows: NDArray[np.int64], values: Floats) -> Floats:
    """Columns (n, p) but for the orders of the load motor's ripple, at which every channel is silent: a late torque
    sensor, say, shifts the ripple it sees.
    """
    waves = [f(k * run.theta[rows]) for k in LOAD_RIPPLE_ORDERS for f in (np.cos, np.sin)]
    columns = np.column_stack([*waves, *(run.rate[rows] * wave for wave in waves)])
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values, rcond=1e-8)[0])


def _states(signals: Signals, rows: slice | NDArray[np.int64]) -> Floats:
    run = signals.run
    columns = (np.abs(run.rate), run.torque, run.temperature, np.where(run.side > 0, 1.0, -1.0))
    return np.column_stack([column[rows] for column in columns])


def _temperature_rows(signals: Signals) -> _Rows | None:
    """The heat balance in integrated form: T − T(0) is linear in 1/C, 1/(RC) and T_amb/(RC); T(0) is free."""
    run = signals.run
    every = 25
    energy = np.cumsum(signals.power) / run.rate_hz
    course = np.cumsum(signals.probe) / run.rate_hz
    table = np.column_stack((energy, course, run.time))[::every]
    rise = signals.probe[::every]
    keep = table.shape[0] > 3
    return (
        _Rows(table - table.mean(axis=0), rise - rise.mean(), _states(signals, slice(None, None, every)))
        if keep
        else None
    )


def project(table: NDArray[Any], excess: Floats, expand: bool = True) -> tuple[Floats, NDArray[np.int64]]:
    """Residual (M,) of the excess after least squares on the nominal's regressors, and the rows (M,) it is of."""
    chosen: NDArray[np.int64] = np.arange(excess.size)
    if not expand:
        scale = np.linalg.norm(table, axis=0)
        scale[scale == 0.0] = 1.0
        scaled = table / scale
        solution = np.linalg.lstsq(scaled, excess, rcond=1e-10)[0]
        return np.asarray(excess - scaled @ solution), chosen
    rng = np.random.default_rng(0)
    if excess.size > _MOST:
        chosen = np.sort(rng.choice(excess.size, _MOST, replace=False))
    theta, x, y, z = table[chosen, :4].T
    basis = np.column_stack((x * x, y * y, z * z, x, y, z, x * y, x * z, y * z, np.ones(x.size)))
    blocks = [basis]
    for order in ORDERS:
        blocks.append(basis * np.cos(order * theta)[:, None])
        blocks.append(basis * np.sin(order * theta)[:, None])
    design = np.concatenate(blocks, axis=1)
    gram = design.T @ design
    gram[np.diag_indices_from(gram)] += 1e-9 * np.trace(gram) / gram.shape[0]
    solution = np.linalg.solve(gram, design.T @ excess[chosen])
    return np.asarray(excess[chosen] - design @ solution), chosen
