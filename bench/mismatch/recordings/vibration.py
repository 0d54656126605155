"""Power spectral densities of the recordings' steady parts, over frequency and over the motor's angle.

They tell how large noise is without any model (a line is in a few bins, noise in all), and hold what is too fast for
block means: tones of the surroundings, ripple of the motor.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.recordings.notch import spectrum
from bench.mismatch.recordings.prepared import Prepared
from bench.simulation.frame import FloatArray
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE

Complex = NDArray[np.complex128]

SEGMENTS_S = (10.0, 5.0, 2.0)
"""lengths of the segments that are averaged, the longest that fits; 10 s give bins of a tenth of a hertz"""
HIGHEST_SHAFT_ORDER = 120
"""per motor revolution: 6k for twenty pole pairs"""
ONE_WAY = 0.9
"""of the mean size of a velocity, which its mean has to be: the rest is how a recording starts"""
NYQUIST_SHARE = 0.42
"""of the sample rate: orders that come closer to half of it are not looked at"""


@dataclass(frozen=True, slots=True)
class Density:
    """Power spectral density of one recording's steady part (K,), unit² per Hz, at multiples of ``step`` Hz.

    ``averaged`` segments; ``rate`` sample rate in Hz; ``rotation_rate`` output revolutions a second.
    """

    recording: int
    power: FloatArray
    step: float
    averaged: float
    rate: float
    rotation_rate: float


@dataclass(frozen=True, slots=True)
class Run:
    """Samples (n,) of a channel in one recording's longest run in motion, at ``rate`` Hz; ``rotation_rate`` output
    revolutions a second. What is not valid has the median.
    """

    recording: int
    samples: FloatArray
    rate: float
    rotation_rate: float


@dataclass(frozen=True, slots=True)
class ShaftSpectrum:
    """Amplitudes a + j·b of a·cos(nθ_m) + b·sin(nθ_m) in one recording's motor torque, n = 0 … HIGHEST_SHAFT_ORDER.

    ``sigma``: standard deviation of each part, by the orders about which nothing stands; ``torque``: mean torque of the
    motor, N·m; ``velocity``: rad/s at the output; ``temperature``: °C; ``too_fast`` (orders,): which come too close to
    half of the recording's sample rate, or are beyond it. There an order is folded, and its vector over the angle is
    right all the same, if no filter before the sampling took it. ``speed``: mean size of the velocity, more than that
    of its mean where the recording reverses; ``load``: mean load torque at the output, N·m; ``shaking``: amplitudes of
    the motor's acceleration as it is smoothed, rad/s², which the inertia makes a torque of; ``hertz``: frequency of the
    first order.
    """

    recording: int
    amplitude: Complex
    sigma: float
    torque: float
    velocity: float
    temperature: float
    too_fast: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    speed: float = 0.0
    load: float = 0.0
    shaking: Complex = field(default_factory=lambda: np.zeros(0, dtype=np.complex128))
    hertz: float = 0.0

    @property
    def one_way(self) -> bool:
        """Whether the recording turns one way only, but for a start."""
        return abs(self.velocity) >= ONE_WAY * self.speed

    @property
    def in_band(self) -> Complex:
        """The amplitudes, not a number where an order is too fast."""
        return np.where(self.too_fast, np.nan, self.amplitude) if self.too_fast.size else self.amplitude


def longest_run(marked: NDArray[np.bool_]) -> tuple[int, int]:
    """Begin and end of the longest run of marked samples; an empty one where there is none."""
    runs = np.flatnonzero(np.diff(np.concatenate(([0], marked.astype(np.int8), [0])))).reshape(-1, 2)
    if runs.size == 0:
        return 0, 0
    a, b = runs[np.argmax(runs[:, 1] - runs[:, 0])].tolist()
    return a, b


@lru_cache(maxsize=8)
def _hann(size: int) -> FloatArray:
    return np.hanning(size)


def density(prepared: Prepared, channel: str, steady: bool = True) -> Density | None:
    """Density of a channel's longest ``steady`` run, or of its longest in motion; None where that is too short."""
    run = run_of(prepared, channel, steady)
    return None if run is None else density_of(run)


def run_of(prepared: Prepared, channel: str, steady: bool = True) -> Run | None:
    """A channel's longest ``steady`` run, or its longest in motion; None where that is too short for a spectrum.

    That of the load torque is of what the load motor does not report, that of the motor torque of what is no reaction
    to the load: a load that wavers is no noise.
    """
    frame, measured, thinning = prepared.frame, prepared.measured[channel], prepared.thinning
    rate = prepared.sample_rate * thinning.group
    a, b = longest_run((frame.direction != 0) & ((frame.steady > 0.5) | (not steady)))
    a, b = a * thinning.group, b * thinning.group
    if b - a < round(min(SEGMENTS_S) * rate):
        return None
    valid = measured.valid[a:b]
    signal = measured.samples[a:b]
    if channel == LOAD_TORQUE:
        signal = signal - thinning.spread(frame.load_motor_torque, measured.samples.size)[a:b]
    elif channel == MOTOR_TORQUE:
        signal = signal - thinning.spread(frame.torque, measured.samples.size)[a:b] / frame.ratio
    signal = np.where(valid, signal, float(np.median(signal[valid])) if valid.any() else 0.0)
    rotation = abs(float(np.median(frame.velocity[a // thinning.group : b // thinning.group]))) / (2.0 * np.pi)
    return Run(int(frame.recording[0]), signal, rate, rotation)


def density_of(run: Run) -> Density:
    """Density of a run (Welch's method, Hann window), in segments of the first of :data:`SEGMENTS_S` that it has."""
    size = next(s for s in (round(length * run.rate) for length in SEGMENTS_S) if run.samples.size >= s)
    number = 1 + (run.samples.size - size) // (size // 2)
    parts = np.lib.stride_tricks.sliding_window_view(run.samples, size)[:: size // 2][:number]
    line = np.linspace(-1.0, 1.0, size)
    level, slope = parts.mean(axis=1), parts @ line / (line @ line)
    taper = _hann(size)
    lines = np.fft.rfft((parts - level[:, None] - slope[:, None] * line) * taper, axis=1)
    power = 2.0 * np.mean(np.abs(lines) ** 2, axis=0) / (run.rate * float(np.sum(taper**2)))
    averaged = max(0.9 * number, 1.0)
    return Density(run.recording, power.astype(np.float32), run.rate / size, averaged, run.rate, run.rotation_rate)


def shaft_spectrum(prepared: Prepared) -> ShaftSpectrum | None:
    """Spectrum over the motor's angle of the steady samples of a recording's motor torque, less its slow part."""
    frame, measured, thinning = prepared.frame, prepared.measured["motor_torque"], prepared.thinning
    groups = (frame.steady > 0.5) & (measured.number > 0) & (frame.direction != 0)
    rows = thinning.spread(groups, measured.samples.size) & measured.valid
    if rows.sum() < 500:
        return None
    angle = prepared.angle[rows] * frame.ratio
    if np.ptp(angle) < 4.0 * np.pi:
        return None
    inner = (
        measured.samples[rows]
        - thinning.spread(_slow(measured.mean, prepared.sample_rate), measured.samples.size)[rows]
    )
    amplitude = 2.0 / rows.sum() * spectrum(angle, inner, HIGHEST_SHAFT_ORDER)
    shaking = frame.acceleration - _slow(frame.acceleration, prepared.sample_rate)
    shaken = thinning.spread(shaking, measured.samples.size)[rows]
    fastest = float(np.percentile(np.abs(frame.omega[groups]), 95)) * np.arange(HIGHEST_SHAFT_ORDER + 1) / (2.0 * np.pi)
    amplitude[0] = np.nan
    too_fast = fastest >= NYQUIST_SHARE * prepared.sample_rate * thinning.group
    # the middle of the squares of a component's two parts is ln 2 of their mean
    middle = np.sqrt(np.median(np.abs(amplitude[1:]) ** 2) / (2.0 * np.log(2.0)))
    return ShaftSpectrum(
        int(frame.recording[0]),
        amplitude,
        float(min(middle, np.std(inner) / np.sqrt(float(rows.sum())))),
        float(np.mean(frame.motor_torque[groups])),
        float(np.mean(frame.velocity[groups])),
        float(np.mean(frame.temperature[groups])),
        too_fast,
        float(np.mean(np.abs(frame.velocity[groups]))),
        float(np.mean(frame.torque_level[groups])),
        2.0 / rows.sum() * spectrum(angle, shaken, HIGHEST_SHAFT_ORDER),
        float(np.mean(np.abs(frame.omega[groups]))) / (2.0 * np.pi),
    )


def _slow(signal: FloatArray, rate: float) -> FloatArray:
    """Running mean over a second: what of a torque is no order of the motor."""
    width = max(1, round(rate) // 2 * 2 + 1)
    if signal.size < 2 * width:
        return np.full(signal.size, float(signal.mean()))
    total = np.cumsum(np.concatenate(([0.0], np.pad(signal, width // 2, mode="edge"))))
    return np.asarray((total[width:] - total[:-width]) / width)
