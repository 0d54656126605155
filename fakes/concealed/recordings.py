"""From ideal signals to what a recording holds: counts, noise, offsets, cut-off files."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from fakes.concealed.campaign import Campaign, Signals
from fakes.concealed.noise import Floats, Noise, Sensors
from fakes.concealed.plant import RATIO

_HOLD_S = 0.05  # the PT100 terminal converts every 50 ms; readings in between repeat the last


@dataclass(frozen=True, slots=True)
class Channel:
    """Raw integers or floats (N,) with SI = raw · scale."""

    raw: NDArray[np.generic]
    unit: str
    scale: float
    description: str


@dataclass(frozen=True, slots=True)
class GeneratedRecording:
    """One recording, ready for any writer.

    Attributes:
        setpoint: (load torque N·m, velocity rad/s load side, temperature °C).
        segments: (name, start, stop), stop −1 where cut off.
    """

    name: str
    kind: str
    started_at: datetime
    rate_hz: float
    setpoint: tuple[float, float, float]
    channels: dict[str, Channel]
    segments: tuple[tuple[str, int, int], ...]
    complete: bool
    events: tuple[tuple[float, str, str], ...] = ()


@dataclass(slots=True)
class NoiseTally:
    """The true noise of each compared channel, by recording.

    Attributes:
        squares: recording id → channel → sum of squares over steady samples. counts: how many these were.
        heat: recording id → RMS of the temperature's noise over every sample: heat is compared in any segment.
    """

    squares: dict[str, dict[str, float]] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    heat: dict[str, float] = field(default_factory=dict)

    def add(self, recording: str, errors: dict[str, Floats], steady: NDArray[np.bool_], stop: int) -> None:
        """Count the samples of one recording up to ``stop``."""
        self.counts[recording] = int(steady.sum())
        self.squares[recording] = {name: float(np.sum(error[steady] ** 2)) for name, error in errors.items()}
        self.heat[recording] = float(np.sqrt(np.mean(errors["temperature"][:stop] ** 2)))

    def rms(self) -> dict[str, float]:
        """RMS of each channel over the steady samples of all recordings."""
        count = max(sum(self.counts.values()), 1)
        names = dict.fromkeys(name for squares in self.squares.values() for name in squares)
        return {n: float(np.sqrt(sum(s[n] for s in self.squares.values()) / count)) for n in names}

    def by_recording(self) -> dict[str, dict[str, float]]:
        """RMS of each channel over each recording's steady samples, of the temperature over all its samples."""
        out = {}
        for recording, squares in self.squares.items():
            count = self.counts[recording]
            noise = {name: float(np.sqrt(total / count)) for name, total in squares.items()} if count else {}
            out[recording] = noise | {"temperature": self.heat[recording]}
        return out


def recording_id(seed: int, number: int) -> str:
    """An id that tells nothing of the point, the order or the case."""
    return hashlib.sha256(f"recording {seed} {number}".encode()).hexdigest()[:10]


def generate_recordings(
    campaign: Campaign,
    sensors: Sensors,
    start: datetime,
    tally: NoiseTally,
    truncate: int | None = None,
    lost: float = 0.0,
    rate_hz: float = 500.0,
) -> Iterator[GeneratedRecording]:
    """Run a campaign and read its sensors.

    ``truncate`` is the index of a recording that is cut short, ``lost`` the share of recordings that lose some cycles.
    """
    for number, signals in enumerate(campaign.run(rate_hz)):
        rng = np.random.default_rng([campaign.seed, 3, number])
        recording = _measure(signals, sensors, start, tally, number, number == truncate, campaign.seed, rng)
        yield _lose_cycles(recording, rng) if rng.random() < lost else recording


def _measure(
    signals: Signals,
    sensors: Sensors,
    start: datetime,
    tally: NoiseTally,
    number: int,
    cut: bool,
    seed: int,
    rng: np.random.Generator,
) -> GeneratedRecording:
    run, motion = signals.run, signals.motion
    hold = max(int(_HOLD_S * run.rate_hz), 1)
    held = (np.arange(run.time.size) // hold) * hold
    ideal: dict[str, tuple[Floats, Noise, str, type[np.integer]]] = {
        "motor_angle": (signals.motor_shaft, sensors.motor_angle, "rad", np.int64),
        "load_angle": (signals.load_angle, sensors.load_angle, "rad", np.int64),
        "motor_velocity": (run.motor_rate, sensors.motor_velocity, "rad/s", np.int32),
        "motor_torque": (signals.motor_torque, sensors.motor_torque, "N·m", np.int16),
        "load_torque": (signals.load_torque, sensors.load_torque, "N·m", np.int16),
        "load_motor_torque": (run.command, sensors.load_motor_torque, "N·m", np.int16),
        "temperature": (signals.probe, sensors.temperature, "°C", np.int16),
    }
    channels: dict[str, Channel] = {}
    error: dict[str, Floats] = {}
    for name, (values, noise, unit, kind) in ideal.items():
        read = values + noise.draw(values.size, run.rate_hz, rng)
        if name == "temperature":
            read = read[held]
        info = np.iinfo(kind)
        raw = np.clip(np.rint(read / noise.step), info.min, info.max).astype(kind)
        error[name] = raw * noise.step - values
        channels[name] = Channel(raw, unit, noise.step, _DESCRIPTIONS[name])
    steady = np.zeros(run.time.size, dtype=bool)
    for name, a, b in motion.segments:
        if name == "steady":
            steady[a:b] = True
    compared = {
        "transmission_error": error["load_angle"] - error["motor_angle"] / RATIO,
        "motor_torque": error["motor_torque"],
        "temperature": error["temperature"],
        "load_torque": error["load_torque"] - error["load_motor_torque"],
    }
    stop = run.time.size
    if cut:
        stop = int(stop * rng.uniform(0.35, 0.8))
        steady[stop:] = False
    tally.add(recording_id(seed, number), compared, steady, stop)
    segments = tuple(
        (n, a, b if b <= stop and not cut else -1 if b > stop else b) for n, a, b in motion.segments if a < stop
    )
    channels = {n: Channel(c.raw[:stop], c.unit, c.scale, c.description) for n, c in channels.items()}
    channels["time"] = Channel(motion.time[:stop], "s", 1.0, "since the first sample")
    return GeneratedRecording(
        name=recording_id(seed, number),
        kind=run.point.kind,
        started_at=start + timedelta(seconds=float(run.clock[0])),
        rate_hz=run.rate_hz,
        setpoint=_setpoint(signals),
        channels=channels,
        segments=segments,
        complete=not cut,
    )


def _lose_cycles(recording: GeneratedRecording, rng: np.random.Generator) -> GeneratedRecording:
    """Leave out a few rows, as the bus does where a working counter was wrong; segments move along."""
    size = recording.channels["time"].raw.size
    keep = np.ones(size, dtype=bool)
    events = list(recording.events)
    for at in np.sort(rng.integers(1, size - 8, int(rng.integers(1, 4)))):
        keep[at : at + int(rng.integers(1, 6))] = False
        events.append((float(at / recording.rate_hz), "warning", "bus cycles lost"))
    moved = np.append(0, np.cumsum(keep))
    segments = tuple((n, int(moved[a]), int(moved[b]) if b >= 0 else -1) for n, a, b in recording.segments)
    channels = {n: replace(c, raw=c.raw[keep]) for n, c in recording.channels.items()}
    return replace(recording, channels=channels, segments=segments, events=tuple(events))


def _setpoint(signals: Signals) -> tuple[float, float, float]:
    point = signals.run.point
    commanded = point.kind in ("constant_velocity", "validation", "heating")
    return (
        float("nan") if point.kind == "torque_ramp" else point.torque,
        point.rate if commanded or point.kind == "torque_ramp" else float("nan"),
        point.temperature if point.kind in ("constant_velocity", "validation") else float("nan"),
    )


_DESCRIPTIONS = {
    "motor_angle": "input motor shaft, unwrapped",
    "load_angle": "load-side encoder, unwrapped",
    "motor_velocity": "input motor shaft",
    "motor_torque": "input motor, at its shaft",
    "load_torque": "torque sensor",
    "load_motor_torque": "load motor, as its drive reports it",
    "temperature": "gearbox lubricant (PT100)",
}
