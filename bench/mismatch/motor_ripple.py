"""Orders of the motor shaft in the motor torque, too fast for blocks: seen in the samples about their block's mean."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.mismatch.prepare import Prepared
from bench.mismatch.spectrum import Complex, nufft
from bench.simulation.frame import FloatArray

HIGHEST = 120
LEAST_GAIN = 30.0
BETTER = 10.0
"""log-likelihood by which ripple in proportion to the torque must beat a constant one"""
LEAST_SIZE = 0.05
NYQUIST_SHARE = 0.42
MOST = 8


@dataclass(frozen=True, slots=True)
class ShaftSpectrum:
    """Amplitudes a + j·b of a·cos(nθ_m) + b·sin(nθ_m) in one recording's motor torque, and their noise.

    n = 0 … HIGHEST; NaN where the order is too fast for the recording's rate.
    """

    recording: int
    amplitude: Complex
    sigma: float
    spread: float
    torque: float = 0.0
    """mean torque of the motor, N·m: ripple can be in proportion to the current"""


@dataclass(frozen=True, slots=True)
class Ripple:
    """An order of the motor shaft: per motor revolution, amplitude (a + j·b, N·m) and gain of log-likelihood.

    ``at`` is the motor torque (N·m) at which it has this amplitude, where it is in proportion to it; 0 where it is
    constant.
    """

    order: int
    amplitude: complex
    gain: float
    at: float = 0.0

    def of(self, torque: float) -> complex:
        """Amplitude at a motor torque."""
        return self.amplitude * (torque / self.at) if self.at else self.amplitude


def shaft_spectrum(prepared: Prepared, slow: FloatArray) -> ShaftSpectrum | None:
    """Spectrum over the motor's angle of the steady samples of a recording's motor torque, less what is ``slow`` of it
    (a row of the frame each).
    """
    frame, own, thinning = prepared.frame, prepared.measured["motor_torque"], prepared.thinning
    groups = (frame.steady > 0.5) & (own.number > 0) & (frame.direction != 0)
    speed = np.abs(frame.omega[groups])
    rows = thinning.spread(groups, own.samples.size) & own.valid
    if rows.sum() < 500 or speed.size == 0:
        return None
    angle = prepared.angle[rows] * frame.ratio
    if np.ptp(angle) < 4.0 * np.pi:
        return None
    inner = (own.samples - thinning.spread(slow, own.samples.size))[rows]
    amplitude = 2.0 / rows.sum() * nufft(angle, inner, HIGHEST)
    fastest = float(np.percentile(speed, 95)) * np.arange(HIGHEST + 1) / (2.0 * np.pi)
    amplitude = np.where(fastest < NYQUIST_SHARE * prepared.sample_rate * thinning.group, amplitude, np.nan)
    amplitude[0] = np.nan
    spread = float(np.std(inner))
    torque = float(np.mean(frame.motor_torque[groups]))
    return ShaftSpectrum(int(frame.recording[0]), amplitude, spread / np.sqrt(rows.sum()), spread, torque)


def without(spectrum: ShaftSpectrum, given: Sequence[Ripple]) -> ShaftSpectrum:
    """A recording's spectrum less the ripple that the simulation has."""
    amplitude = spectrum.amplitude.copy()
    for ripple in given:
        if 0 < ripple.order <= HIGHEST:
            amplitude[ripple.order] -= ripple.of(spectrum.torque)
    return replace(spectrum, amplitude=amplitude)


def search(spectra: list[ShaftSpectrum], train: set[int]) -> list[Ripple]:
    """Orders that stand in the training recordings with one amplitude and phase, or with one in proportion to the
    motor's torque, strongest first.
    """
    chosen = [s for s in spectra if s.recording in train]
    if len(chosen) < 5:
        return []
    amplitude = np.array([s.amplitude for s in chosen])
    seen = np.isfinite(amplitude)
    sigma = np.array([s.sigma for s in chosen])[:, None]
    # neighbouring orders tell the level of the noise, whatever its colour
    level = np.sqrt(np.nanmedian(np.where(seen, np.abs(amplitude) ** 2, np.nan), axis=1) / np.log(2.0) / 2.0)[:, None]
    noise = np.maximum(sigma, np.where(np.isfinite(level), level, sigma))
    weight = np.where(seen, 1.0 / noise**2, 0.0)
    values = np.where(seen, amplitude, 0.0)
    torque = np.array([s.torque for s in chosen])
    at = float(np.sqrt(np.mean(torque**2)))
    spread = float(np.median([s.spread for s in chosen]))
    found: dict[int, Ripple] = {}
    for reference in (0.0, at):
        shape = torque[:, None] / reference if reference else np.ones((torque.size, 1))
        mean, gain = _predicted(values, weight, shape)
        good = (seen.sum(axis=0) >= 5) & (gain > LEAST_GAIN) & (np.abs(mean) > LEAST_SIZE * np.sqrt(2.0) * spread)
        for n in map(int, np.flatnonzero(good)):
            if n not in found or gain[n] > found[n].gain + BETTER:
                found[n] = Ripple(n, complex(mean[n]), float(gain[n]), reference)
    return sorted(found.values(), key=lambda r: -r.gain)[:MOST]


def _predicted(values: Complex, weight: FloatArray, shape: FloatArray) -> tuple[Complex, FloatArray]:
    """Amplitude of each order over ``shape`` (recordings, 1), and its gain where each recording is predicted by the
    others.
    """
    total, energy = (weight * shape * values).sum(axis=0), (weight * shape**2).sum(axis=0)
    others = (total - weight * shape * values) / np.maximum(energy - weight * shape**2, 1e-300)
    gain = 0.5 * np.sum(weight * (np.abs(values) ** 2 - np.abs(values - shape * others) ** 2), axis=0)
    return np.asarray(total / np.maximum(energy, 1e-300)), np.asarray(gain)
