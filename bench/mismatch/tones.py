"""Tones: vibration at a fixed frequency, whatever the speed, with a phase of its own in every recording.

No regressor can follow it (its phase cannot be predicted), and no order of the gearbox stays at one frequency when the
speed changes. So the periodograms of all recordings are laid over each other in hertz: what belongs to the shaft moves
from recording to recording, what belongs to the surroundings stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from bench.simulation.frame import FloatArray

SEGMENT_S = 4.096
"""length of the periodograms' segments: bins of a quarter of a hertz, the same at every sample rate"""
HIGHEST_HZ = 200.0
LOWEST_BIN = 10
"""below two hertz a bin's neighbours lie on the slope of coloured noise"""
NEAR, FAR = 4, 10
"""the surroundings of a bin: so many bins away on either side"""
LEAST_RECORDINGS = 8
LEAST_RATIO = 1.6
"""of a bin's power over its neighbours', the median of all recordings"""
LEAST_SIGMAS = 8.0


@dataclass(frozen=True, slots=True)
class ToneSpectrum:
    """Power over frequency (K,) of a recording's steady part, relative to the power about each bin; ``power`` in the
    channel's unit squared a bin.
    """

    recording: int
    relative: FloatArray
    power: FloatArray
    bin_hz: float


@dataclass(frozen=True, slots=True)
class Tone:
    """A fixed frequency in a channel: Hz, amplitude and its standard deviation in the channel's unit, width of a bin,
    power over its surroundings, recordings that show it.
    """

    frequency: float
    amplitude: float
    deviation: float
    bin_hz: float
    ratio: float
    recordings: tuple[int, ...]


def tone_spectrum(
    index: int, signal: FloatArray, valid: NDArray[np.bool_], steady: NDArray[np.bool_], rate: float
) -> ToneSpectrum | None:
    """Spectrum of the longest steady run of a recording; None where that is shorter than two segments."""
    segment = round(SEGMENT_S * rate)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], steady.astype(np.int8), [0]))))
    runs = edges.reshape(-1, 2)
    if runs.size == 0:
        return None
    a, b = runs[np.argmax(runs[:, 1] - runs[:, 0])]
    if b - a < 2 * segment:
        return None
    own = np.where(valid[a:b], signal[a:b], np.median(signal[a:b]))
    limit = 6.0 * 1.4826 * float(np.median(np.abs(own - np.median(own)))) or 1.0
    own = np.clip(own - np.median(own), -limit, limit)
    frequency, power = welch(own, rate, window="hann", nperseg=segment, detrend="constant", scaling="density")
    keep = int(np.searchsorted(frequency, min(HIGHEST_HZ, 0.45 * rate)))
    power = power[:keep]
    background = _surroundings(power)
    return ToneSpectrum(index, power / np.maximum(background, 1e-300), power - background, float(frequency[1]))


def _surroundings(power: FloatArray) -> FloatArray:
    """Median power some bins to the left and to the right of each bin: the larger of the two, so that a slope is no
    peak.
    """
    padded = np.pad(power, FAR, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, FAR - NEAR + 1)
    middle = np.median(windows, axis=1)
    left, right = middle[: power.size], middle[FAR + NEAR : FAR + NEAR + power.size]
    return np.asarray(np.maximum(left, right))


def search(spectra: Sequence[ToneSpectrum]) -> list[Tone]:
    """Frequencies whose power stands out of its surroundings in most recordings."""
    if len(spectra) < LEAST_RECORDINGS:
        return []
    keep = min(s.relative.size for s in spectra)
    relative = np.array([s.relative[:keep] for s in spectra])
    middle = np.median(relative, axis=0)
    usual = float(np.median(middle[LOWEST_BIN:]))
    spread = 1.4826 * float(np.median(np.abs(middle[LOWEST_BIN:] - usual)))
    out: list[Tone] = []
    left = middle.copy()
    left[:LOWEST_BIN] = 0.0
    while len(out) < 3:
        k = int(np.argmax(left))
        if left[k] < max(LEAST_RATIO * usual, usual + LEAST_SIGMAS * spread):
            break
        near = slice(max(k - 2, 0), k + 3)
        width = spectra[0].bin_hz
        energy = np.array([max(float(s.power[near].sum()), 0.0) * width for s in spectra])
        shown = tuple(s.recording for s, row in zip(spectra, relative, strict=True) if row[k] > LEAST_RATIO * usual)
        weight = relative[:, near].mean(axis=0) - usual
        weight = np.maximum(weight, 0.0)
        centre = float(np.sum(weight * np.arange(near.start, near.stop)) / max(float(weight.sum()), 1e-300)) * width
        amplitude = np.sqrt(2.0 * energy)
        spread_of = float(np.std(amplitude) / np.sqrt(amplitude.size))
        out.append(Tone(centre, float(np.median(amplitude)), spread_of, width, float(left[k] / usual), shown))
        left[max(k - 4, 0) : k + 5] = 0.0
    return out
