"""Sensors: resolution, coloured and heavy-tailed noise, spikes, offsets between recordings."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Floats = NDArray[np.float64]

#: Nuisances of :func:`roughen`.
NUISANCE_NAMES = ("quiet", "coloured", "heavy_tailed", "spiky", "offsets")


@dataclass(frozen=True, slots=True)
class Noise:
    """Noise of one sensor in its SI unit.

    Attributes:
        sigma: RMS of the sample noise.
        colour: share of its variance that is coloured (first order).
        memory: its correlation time in s.
        tail: degrees of freedom of Student's t, 0 for Gaussian.
        spikes: spikes a second, each of 6 to 15 sigma.
        offset: RMS of the offset between recordings, in units of sigma.
        step: resolution.
    """

    sigma: float
    step: float
    colour: float = 0.2
    memory: float = 0.05
    tail: float = 0.0
    spikes: float = 0.0
    offset: float = 0.1

    def draw(self, count: int, rate_hz: float, rng: np.random.Generator) -> Floats:
        """Noise (count,) before quantisation, the recording's own offset included."""
        white = self._white(count, rng) * np.sqrt(1.0 - self.colour)
        if self.colour > 0.0:
            keep = np.exp(-1.0 / (self.memory * rate_hz))
            first = rng.normal(0.0, 1.0)
            drive = rng.normal(0.0, np.sqrt(1.0 - keep**2), count)
            coloured, _state = lfilter([1.0], [1.0, -keep], drive, zi=np.array([keep * first]))
            white = white + np.sqrt(self.colour) * coloured
        hits = rng.random(count) < self.spikes / rate_hz
        white[hits] += rng.choice([-1.0, 1.0], int(hits.sum())) * rng.uniform(6.0, 15.0, int(hits.sum()))
        return np.asarray(self.sigma * (white + self.offset * rng.normal()))

    def _white(self, count: int, rng: np.random.Generator) -> Floats:
        if self.tail <= 2.0:
            return rng.normal(0.0, 1.0, count)
        return np.asarray(rng.standard_t(self.tail, count) / np.sqrt(self.tail / (self.tail - 2.0)))


@dataclass(frozen=True, slots=True)
class Sensors:
    """All sensors of a bench; steps follow from 13 and 25 bit encoders, 16 bit ADC, per-mille drive torques, PT100."""

    load_angle: Noise
    motor_angle: Noise
    motor_velocity: Noise
    motor_torque: Noise
    load_torque: Noise
    load_motor_torque: Noise
    temperature: Noise


def draw_sensors(rng: np.random.Generator) -> Sensors:
    """Sensors of an ordinary bench: mostly white, slightly coloured, small offsets between recordings."""

    def around(value: float) -> float:
        return float(value * np.exp(rng.normal(0.0, 0.2)))

    return Sensors(
        load_angle=Noise(
            around(3.5e-6), 2 * np.pi / 2**25, colour=rng.uniform(0.1, 0.4), memory=rng.uniform(0.01, 0.1)
        ),
        motor_angle=Noise(around(1.5e-4), 2 * np.pi / 2**13, colour=0.0, offset=0.0),
        motor_velocity=Noise(around(0.06), 1e-3, colour=0.3, memory=0.01, offset=0.0),
        motor_torque=Noise(around(0.05), 0.0175, colour=rng.uniform(0.1, 0.4), memory=rng.uniform(0.01, 0.1)),
        load_torque=Noise(around(2.0), 20000.0 / 2**16, colour=rng.uniform(0.1, 0.4), memory=rng.uniform(0.01, 0.1)),
        load_motor_torque=Noise(around(1.0), 1.65, colour=0.1, offset=0.02),
        temperature=Noise(around(0.02), 0.01, colour=rng.uniform(0.1, 0.3), memory=rng.uniform(0.05, 0.5)),
    )


def roughen(sensors: Sensors, how: str, rng: np.random.Generator) -> Sensors:
    """The same sensors with one nuisance an analyser must not take for physics.

    ``how``: ``coloured``, ``heavy_tailed``, ``spiky``, ``offsets`` or ``quiet`` (nothing added).
    """
    table = {
        "quiet": {},
        "coloured": {"colour": rng.uniform(0.6, 0.9), "memory": rng.uniform(0.1, 1.0)},
        "heavy_tailed": {"tail": rng.uniform(2.6, 4.0)},
        "spiky": {"spikes": rng.uniform(0.1, 0.8)},
        "offsets": {"offset": rng.uniform(0.3, 0.8)},
    }
    change = table[how]
    names = ("load_angle", "motor_torque", "load_torque", "temperature")
    return replace(sensors, **{name: replace(getattr(sensors, name), **change) for name in names})


def scaled(sensors: Sensors, factor: float) -> Sensors:
    """The same sensors with ``factor`` times the noise, their resolution unchanged."""
    names = ("load_angle", "motor_torque", "load_torque", "temperature")
    louder = {name: replace(getattr(sensors, name), sigma=factor * getattr(sensors, name).sigma) for name in names}
    return replace(sensors, **louder)
