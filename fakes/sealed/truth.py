"""The truth about recordings of a bench with physics concealed in its plant.

What an effect adds to a channel was written down while the plant ran (its ledger). Strength and place are those of the
excess: what is left of it once the nominal simulation is fitted to it. What is noise is found on a twin: the same
campaign on a bench that conceals nothing, from which the fitted nominal simulation is taken off. So noise is
everything that no model of this structure predicts, the unrest of the drives' own loops included.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fakes.concealed.clutter import merged
from fakes.concealed.location import measured_location
from fakes.concealed.strength import Excess, project, strength
from fakes.concealed.truth import CHANNELS, ConcealedEffect, Location, Truth
from fakes.plant.hidden.kinds import SHOWN, Hidden
from fakes.plant.hidden.ledger import EVERY, read_ledger
from fakes.plant.spec import plant_of
from fakes.plant.truth import PlantTruth

Floats = NDArray[np.float64]
Samples = Sequence[Mapping[str, Any]]
"""one mapping a recording: ``id`` and arrays (n,) of ``cycle``, ``steady`` and channels, every EVERY-th bus cycle"""
_RIPPLE = (150.0, 300.0)
_TIED = {"ripple": (4440.0,), "eccentric": (185.0,)}
"""orders of what is tied to the motor's shaft, per output revolution"""
FAINTEST = 0.15
"""strength below which nobody is asked to see an effect: where it acts it makes what is left larger by one per cent"""
_STANDSTILL = 0.5
"""rad/s at the motor below which a shaft has no direction"""
_FEWEST, _WAVES = 50, 3.0
"""samples, and waves of the ripple, from which it can be told from what else there is"""
_SLOWER, _FASTER, _SUDDEN = 0.2, 1.1, 0.5
"""of the slowest and the fastest steady speed, between which the transmission error is compared; of the fastest, by
which the speed may change a second"""


def noise_of(samples: Samples) -> dict[str, dict[str, float]]:
    """Return recording → channel → noise RMS of a bench that conceals nothing."""
    out: dict[str, dict[str, float]] = {one["id"]: {} for one in samples}
    for channel in CHANNELS:
        inside = [
            compared & one["steady"]
            for compared, one in zip(_comparable_samples(samples, channel), samples, strict=True)
        ]
        if channel == "temperature":
            inside = _comparable_samples(samples, channel)
        left = _fit_residual(samples, channel, [_channel_values(one, channel) for one in samples], inside)
        for number, one in enumerate(samples):
            rest = left.values[left.recording == number]
            if rest.size:
                out[one["id"]][channel] = float(np.sqrt(np.mean(rest**2)))
    return out


def truth_of(
    plant: str,
    ledger: str,
    samples: Samples,
    noise: Mapping[str, Mapping[str, float]],
    case: str,
    seed: int,
    folder: str,
) -> dict[str, Any]:
    """Return the truth as a score reads it.

    Args:
        plant: the name the plant was run under. ledger: what it wrote. samples: of its recordings.
        noise: recording → channel → noise RMS (:func:`noise_of`). case, seed, folder: as they are called.
    """
    bench = plant_of(plant)
    shown = read_ledger(ledger, len(bench.hidden))["shown"]
    level = {
        channel: float(np.sqrt(np.mean([row[channel] ** 2 for row in noise.values() if channel in row])))
        for channel in CHANNELS
    }
    effects = [_effect_of(one, number, shown, samples, level) for number, one in enumerate(bench.hidden)]
    effects = merged(effects, _weak_orders(bench, level["transmission_error"]))
    ids = {one["id"] for one in samples}
    truth = Truth(
        case=case,
        group="through",
        seed=seed,
        folder=folder,
        verdict="mismatch" if effects else "match",
        effects=tuple(effects),
        noise_rms=level,
        noise_by_recording={key: dict(row) for key, row in noise.items() if key in ids},
        note="in the plant's dynamics",
    )
    return truth.to_dict()


def _effect_of(
    hidden: Hidden, number: int, shown: NDArray[Any], samples: Samples, level: Mapping[str, float]
) -> ConcealedEffect:
    kind = hidden.definition
    at = SHOWN.index(kind.channel)
    values = [shown[one["cycle"] // EVERY, number, at].astype(np.float64) for one in samples]
    excess = _fit_residual(samples, kind.channel, values, _comparable_samples(samples, kind.channel))
    size = strength(excess.values, level[kind.channel])
    return ConcealedEffect(
        effect=kind.effect,
        status="unknown" if kind.effect == "unknown" else "named",
        form=kind.text,
        channels=(kind.channel,),
        strength=round(size, 3),
        too_faint=size < FAINTEST,
        location=_over_all_samples(
            measured_location(_claimed_location(hidden), excess, lambda i: str(samples[i]["id"])), kind.channel, samples
        ),
        in_library=kind.in_library,
    )


def _over_all_samples(location: Location, channel: str, samples: Samples) -> Location:
    """The place with its span widened to all samples at which the channel is compared."""
    if not location.span:
        return location
    inside = _comparable_samples(samples, channel)
    quantities = {"velocity": "rate", "load_torque": "torque", "temperature": "temperature"}
    span = {}
    for name, source in quantities.items():
        values = np.concatenate([one[source][chosen] for one, chosen in zip(samples, inside, strict=True)])
        values = np.abs(values) if name == "velocity" else values
        span[name] = (float(values.min()), float(values.max()))
    return replace(location, span=span)


def _claimed_location(hidden: Hidden) -> Location:
    """Place that follows from the parameters of the physics itself."""
    values = dict(zip(hidden.definition.parameters, hidden.parameters, strict=True))
    if hidden.kind in ("lost_arctan", "lost_root"):
        outer, core = ({"load_torque": [-k * values["torque"], k * values["torque"]]} for k in (3.0, 1.0))
        return Location(conditions=outer, core=core)
    if hidden.kind in ("defect", "tight_spot"):
        half = 1.0 / np.sqrt(values["sharpness"])
        windows, core_windows = (((values["angle"] - k * half, values["angle"] + k * half),) for k in (2.0, 0.8))
        return Location(angle_windows=windows, core_windows=core_windows)
    if hidden.kind == "sideband":
        return Location(orders=(values["order"] - values["beat"], values["order"] + values["beat"]))
    if hidden.kind in ("harmonic", "tight_wave"):
        return Location(orders=(values["order"],))
    return Location(orders=_TIED.get(hidden.kind, ()))


def _weak_orders(bench: PlantTruth, noise: float) -> ConcealedEffect | None:
    """The weak orders as one effect, as a bench has them by default."""
    series = bench.transmission_error
    if not series.weak.any():
        return None
    sizes = np.abs(series.amplitude[:, series.weak, 9]).mean(axis=0) / np.sqrt(2.0)
    by_size = np.argsort(-sizes)
    return ConcealedEffect(
        effect="te.harmonic",
        status="named",
        form="weak orders of the gearbox",
        channels=("transmission_error",),
        strength=round(float(np.sqrt(np.sum(sizes**2)) / noise), 3),
        location=Location(
            orders=tuple(float(series.orders[series.weak][i]) for i in by_size),
            order_sizes=tuple(float(sizes[i]) for i in by_size),
        ),
    )


def _channel_values(one: Mapping[str, Any], channel: str) -> Floats:
    if channel == "transmission_error":
        return np.asarray(one["load_angle"] - one["theta"])
    if channel == "load_torque":
        return np.asarray(one["load_torque"] - one["load_motor_torque"])
    if channel == "motor_torque":
        return np.asarray(one["motor_torque"] - one["torque"] / one["ratio"])
    return np.asarray(one[channel])


def _comparable_samples(samples: Samples, channel: str) -> list[NDArray[np.bool_]]:
    """Which samples of each recording are compared in a channel.

    The temperature always. The torques in motion, starts and ramps and heating included: at rest friction has no
    direction. The transmission error in motion as well, but not while the speed changes at once, nor at speeds at which
    no revolution was steady: the series holds within the campaign's bounds (bench-physics, "Nominal simulation" 1).
    """
    if channel == "temperature":
        return [np.ones(one["rate"].size, dtype=bool) for one in samples]
    moving = [np.abs(one["rate"]) * one["ratio"] > _STANDSTILL for one in samples]
    if channel != "transmission_error":
        return moving
    speeds = [abs(float(np.median(one["rate"][one["steady"]]))) for one in samples if np.any(one["steady"] != 0)]
    slowest, fastest = min(speeds, default=0.0), max(speeds, default=np.inf)
    out = []
    for one, in_motion in zip(samples, moving, strict=True):
        speed, change = np.abs(one["rate"]), np.abs(np.gradient(one["rate"], one["step_s"]))
        bounds = (speed > _SLOWER * slowest) & (speed < _FASTER * fastest) & (change < _SUDDEN * fastest)
        out.append(in_motion & bounds)
    return out


def _fit_residual(
    samples: Samples, channel: str, values: Sequence[Floats], inside: Sequence[NDArray[np.bool_]]
) -> Excess:
    """What is left of ``values``, one array a recording, once the nominal simulation is fitted to those ``inside``."""
    tables, left, states, numbers = [], [], [], []
    for number, (one, series, chosen) in enumerate(zip(samples, values, inside, strict=True)):
        if np.count_nonzero(chosen) < 10:
            continue
        table = _table(one, channel)[chosen]
        picked = series[chosen]
        if channel == "temperature":
            # the start of each recording is free
            table, picked = table - table.mean(axis=0), picked - picked.mean()
        elif channel != "transmission_error":
            whole = _remove_ripple(one, np.column_stack([picked, table]), chosen)
            picked, table = whole[:, 0], whole[:, 1:]
        tables.append(table)
        left.append(picked)
        states.append(np.column_stack([np.abs(one["rate"]), one["torque"], one["temperature"], one["side"]])[chosen])
        numbers.append(np.full(picked.size, number))
    table, excess = np.concatenate(tables), np.concatenate(left)
    state, recording = np.concatenate(states), np.concatenate(numbers)
    if channel != "transmission_error":
        return Excess(project(table, excess, expand=False)[0], state, recording, np.ones(excess.size))
    parts = []
    for side in (-1.0, 1.0):
        of = np.flatnonzero(table[:, -1] == side)
        if of.size:
            rest, chosen_rows = project(table[of], excess[of])
            at = of[chosen_rows]
            parts.append((rest, state[at], recording[at], np.full(at.size, of.size / at.size)))
    return Excess(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _remove_ripple(one: Mapping[str, Any], values: Floats, chosen: NDArray[np.bool_]) -> Floats:
    """Values (m, k) at the samples chosen, less the load motor's ripple: each recording's own, in each direction.

    The simulation is silent at these orders (bench-physics, "Nominal simulation" 1): what an effect does to them is
    taken off with them.
    """
    out = values.copy()
    angle, side = one["load_angle"][chosen], one["side"][chosen]
    for way in (-1.0, 1.0):
        mask = side == way
        if np.count_nonzero(mask) < _FEWEST or np.ptp(angle[mask]) < _WAVES * 2.0 * np.pi / _RIPPLE[0]:
            continue
        waves = np.column_stack([wave(order * angle[mask]) for order in _RIPPLE for wave in (np.cos, np.sin)])
        whole = np.column_stack([waves, np.ones(waves.shape[0])])
        out[mask] -= waves @ np.linalg.lstsq(whole, values[mask], rcond=None)[0][:-1]
    return out


def _table(one: Mapping[str, Any], channel: str) -> Floats:
    """Regressors (n, p) of the nominal simulation in a channel."""
    rate, torque, temperature, side = (one[name] for name in ("rate", "torque", "temperature", "side"))
    speed = rate * one["ratio"]
    sign = np.where(np.abs(speed) > _STANDSTILL, side, 0.0)
    acceleration, steady = np.gradient(rate, one["step_s"]), np.ones(rate.size)
    if channel == "transmission_error":
        scaled = (np.clip(torque, -1150.0, 1150.0) / 1000.0, np.abs(rate) / 0.17, (temperature - 35.0) / 15.0)
        return np.column_stack([one["theta"], *scaled, side])
    if channel == "load_torque":
        return np.column_stack([sign, acceleration, steady])
    if channel == "motor_torque":
        load = sign * np.abs(torque) / one["ratio"]
        # the load's own part, torque over ratio, has no parameter: it is taken off (:func:`_measured`)
        columns = [sign, speed, speed * (temperature - 25.0), load, acceleration, steady]
        return np.column_stack(columns)
    power = np.abs(one["motor_torque"] * speed - torque * rate)
    time = np.arange(rate.size) * one["step_s"]
    columns = [np.cumsum(power), np.cumsum(temperature), time / one["step_s"]]
    return np.asarray(np.column_stack(columns) * one["step_s"])
