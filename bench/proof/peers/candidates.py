"""A careful user's library: candidate columns for the vocabulary, channel by channel, and the simulation's own."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bench.proof.peers.rows import DAHL_LENGTHS, LAGS_S, PLAY_WIDTHS, Rows

Floats = NDArray[np.float64]
Column = tuple[str, Floats]

TE_ORDERS = (1, 3, 6, 9, 13, 14, 18, 19, 27, 4, 12, 46, 92, 138, 184, 276, 24, 90, 135, 180)
RIPPLE_ORDERS = (150, 300)
_RATIO = 185.0
_SCREENED = 6


@dataclass(frozen=True, slots=True)
class Problem:
    """One channel: residual ``y`` (M,) of the simulation, its parameters' columns projected out of everything.

    Attributes:
        columns: (M, K) candidates, orthogonal to the simulation and of unit RMS.
        effects, orders: what each column stands for.
        recording: (M,) recording of each row; names: the recordings' ids.
        states: (M,) of speed, load torque, temperature, direction, and how many samples a row stands for (weight).
    """

    channel: str
    y: Floats
    columns: Floats
    effects: tuple[str, ...]
    orders: tuple[float, ...]
    recording: NDArray[np.int64]
    train: NDArray[np.bool_]
    states: Mapping[str, Floats] = field(default_factory=dict)
    names: tuple[str, ...] = ()


def problems(rows: Rows, seed: int = 0) -> Iterator[Problem]:
    """The four channels' problems of a folder; a quarter of the recordings is held out."""
    rng = np.random.default_rng(seed)
    names = np.unique(rows.recording)
    held = rng.choice(names, max(names.size // 4, 1), replace=False)
    for channel, (base, library, target) in _CHANNELS.items():
        use = rows.settled & rows.within if channel == "transmission_error" else rows.settled
        picked = rows.where(use)
        train = ~np.isin(picked.recording, held)
        keep = base(picked)
        y = _orthogonal(keep, target(picked), train)
        listed = list(library(picked))
        listed += _screened(channel, picked, y, train)
        columns = _orthogonal(keep, np.column_stack([column for _name, column in listed]), train)
        size = np.sqrt(np.mean(columns[train] ** 2, axis=0))
        good = size > 1e-9 * np.maximum(np.sqrt(np.mean(np.column_stack([c for _n, c in listed]) ** 2, axis=0)), 1e-30)
        tags = [name.partition("@") for name, _column in listed]
        yield Problem(
            channel,
            y,
            columns[:, good] / size[good],
            tuple(tag[0] for tag, ok in zip(tags, good, strict=True) if ok),
            tuple(float(tag[2] or "nan") for tag, ok in zip(tags, good, strict=True) if ok),
            picked.recording,
            train,
            {
                "velocity": np.abs(picked["rate"]),
                "load_torque": picked["torque"],
                "temperature": picked["temperature"],
                "direction": picked["side"],
                "weight": picked["weight"],
            },
            picked.names,
        )


def _orthogonal(base: Floats, values: Floats, train: NDArray[np.bool_]) -> Floats:
    scale = np.linalg.norm(base[train], axis=0)
    scale[scale == 0.0] = 1.0
    scaled = base / scale
    gram = scaled[train].T @ scaled[train]
    gram[np.diag_indices_from(gram)] += 1e-9
    return np.asarray(values - scaled @ np.linalg.solve(gram, scaled[train].T @ values[train]))


def _waves(theta: Floats, orders: tuple[float, ...]) -> Iterator[tuple[float, Floats]]:
    for order in orders:
        yield order, np.cos(order * theta)
        yield order, np.sin(order * theta)


def _te_base(r: Rows) -> Floats:
    x, y, z = r["torque"] / 1000.0, np.abs(r["rate"]) / 0.17, (r["temperature"] - 35.0) / 15.0
    poly = np.column_stack((x * x, y * y, z * z, x, y, z, x * y, x * z, y * z, np.ones(x.size)))
    blocks = [poly]
    blocks += [poly * wave[:, None] for _k, wave in _waves(r["theta"], tuple(map(float, TE_ORDERS)))]
    one = np.concatenate(blocks, axis=1)
    side = r["side"][:, None] > 0.0
    ripple = [wave[:, None] for _k, wave in _waves(r["theta"], RIPPLE_ORDERS)]
    return np.concatenate([one * side, one * ~side, *ripple], axis=1)


def _motor_base(r: Rows) -> Floats:
    w, d = r["motor_rate"], r["sign"]
    ripple = [wave for _k, wave in _waves(r["theta"], RIPPLE_ORDERS)]
    friction = (d, w, w * (r["temperature"] - 25.0), d * np.abs(r["torque"]) / _RATIO)
    return np.column_stack((*friction, r["acceleration"], np.ones(w.size), *ripple))


def _load_base(r: Rows) -> Floats:
    ripple = [wave for _k, wave in _waves(r["theta"], RIPPLE_ORDERS)]
    return np.column_stack((r["sign"], r["acceleration"], np.ones(r["sign"].size), *ripple))


def _temperature_base(r: Rows) -> Floats:
    return np.column_stack([_centred(r, r[name]) for name in ("energy", "degree_seconds", "elapsed")])


def _centred(r: Rows, values: Floats) -> Floats:
    """Values less their mean over each recording: where a recording starts is not predicted."""
    mean = np.bincount(r.recording, values) / np.maximum(np.bincount(r.recording), 1)
    return np.asarray(values - mean[r.recording])


def _te_library(r: Rows) -> Iterator[Column]:
    x, v, t, h = r["torque"], np.abs(r["rate"]), r["temperature"], r["hours"]
    for scale in (30.0, 80.0, 150.0):
        yield "te.lost_motion", np.tanh(x / scale)
    for knee in (400.0, 550.0):
        yield "te.stiffness_nonlinear", np.sign(x) * np.clip(np.abs(x) - knee, 0.0, None)
    yield "te.stiffness_nonlinear", x**3
    for width in PLAY_WIDTHS:
        yield "te.hysteresis", r[f"play_{width:g}"]
    for pace in (0.5, 2.0):
        yield "te.drift_time", np.exp(-h / pace)
    yield "te.drift_time", h
    for slow in (0.01, 0.03):
        yield "te.velocity_nonlinear", r["side"] * np.exp(-v / slow)
    for centre in (28.0, 32.0, 36.0):
        yield "te.temperature_nonlinear", np.tanh((t - centre) / 3.0)
    yield "te.temperature_nonlinear", np.exp(-t / 12.0)
    yield "sensor.timing_skew", r["torque_rate"]


def _motor_library(r: Rows) -> Iterator[Column]:
    w, d, t, theta = r["motor_rate"], r["sign"], r["temperature"], r["theta"]
    for slow in (3.0, 6.0, 12.0):
        yield "friction.stribeck", d * np.exp(-((w / slow) ** 2))
    yield "friction.viscous_quadratic", w * np.abs(w)
    for fall in (12.0, 25.0):
        yield "friction.viscous_temperature", w * np.exp(-(t - 25.0) / fall)
    for order, wave in _waves(theta, (1.0, 2.0, 3.0, 4.0)):
        yield f"friction.position_dependent@{order:g}", d * wave
    for pace in (0.5, 2.0):
        yield "friction.run_in", d * np.exp(-r["hours"] / pace)
    yield "friction.run_in", d * np.exp(-r["travel"] / 400.0)
    for length in DAHL_LENGTHS:
        yield "friction.presliding", r[f"dahl_{length:g}"] - d
    for _order, wave in _waves(theta, (24.0 * _RATIO,)):
        yield "motor.torque_ripple@4440", wave
        yield "motor.torque_ripple@4440", wave * r["torque"] / 1000.0
    yield "motor.torque_constant", r["torque"]
    yield "motor.torque_constant", r["motor_torque"] ** 3
    for _order, wave in _waves(theta, (1.0,)):
        yield "load.unbalance@1", wave


def _load_library(r: Rows) -> Iterator[Column]:
    x = r["load_motor_torque"]
    yield "sensor.torque_zero_temperature", r["temperature"]
    yield "sensor.torque_gain", x
    yield "sensor.torque_nonlinearity", x**2
    yield "sensor.torque_nonlinearity", x**3
    for width in PLAY_WIDTHS:
        yield "sensor.torque_hysteresis", r[f"play_{width:g}"]
    yield "sensor.timing_skew", r["torque_rate"]
    for _order, wave in _waves(r["theta"], (1.0,)):
        yield "load.unbalance@1", wave


def _temperature_library(r: Rows) -> Iterator[Column]:
    for lag, name in zip(LAGS_S, ("sensor_lag", "sensor_lag", "second_mass"), strict=True):
        yield f"thermal.{name}", _centred(r, r[f"lag_{lag:g}"])
    yield "thermal.ambient_drift", _centred(r, r["hours"] * r["elapsed"])
    yield "thermal.convection_speed", _centred(r, r["fan_degree_seconds"])


def _screened(channel: str, r: Rows, y: Floats, train: NDArray[np.bool_]) -> list[Column]:
    """The strongest orders and angle windows of the residual, as a user would pick them from a spectrum."""
    if channel != "transmission_error":
        return []
    taken = {*TE_ORDERS, *RIPPLE_ORDERS}
    orders = np.array([k for k in range(1, 400) if k not in taken] + [740.0])
    phase = np.exp(-1j * np.outer(r["theta"][train][::3], orders))
    power = np.abs(y[train][::3] @ phase)
    best = sorted(float(k) for k in orders[np.argsort(power)[-_SCREENED:]])
    out: list[Column] = []
    for order in best:
        mirrored = any(2 * f - order in best for f in TE_ORDERS)
        effect = "sensor.motor_encoder" if order % _RATIO == 0.0 else "te.sideband" if mirrored else "te.harmonic"
        out += [(f"{effect}@{order:g}", wave) for _k, wave in _waves(r["theta"], (order,))]
    bins = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
    pulses = [np.exp(60.0**2 / 2.0 * (np.cos(r["theta"] - at) - 1.0)) for at in bins]
    heights = np.array([abs(p[train] @ y[train]) / np.sqrt(p[train] @ p[train] + 1e-9) for p in pulses])
    out += [("te.local_defect", pulses[int(i)]) for i in np.argsort(heights)[-2:]]
    return out


_Base = Callable[[Rows], Floats]
_CHANNELS: dict[str, tuple[_Base, Callable[[Rows], Iterator[Column]], _Base]] = {
    "transmission_error": (_te_base, _te_library, lambda r: r["te"]),
    "motor_torque": (_motor_base, _motor_library, lambda r: r["motor_torque"] - r["torque"] / _RATIO),
    "load_torque": (_load_base, _load_library, lambda r: r["sensor"] - r["load_motor_torque"]),
    "temperature": (_temperature_base, _temperature_library, lambda r: _centred(r, r["temperature"])),
}
