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

from bench.mismatch.smoothing import ENOUGH_SAMPLES
from bench.simulation.frame import FloatArray

SEGMENT_S = 10.0
"""length of the periodograms' segments: bins of a tenth of a hertz, the same at every sample rate"""
HIGHEST_HZ = 200.0
LOWEST_BIN = 7
"""below 0.7 Hz a bin has no neighbours on its left"""
NEAR, FAR = 4, 10
"""the surroundings of a bin: so many bins away on either side"""
LOW_NEAR, LOW_FAR = 3, 6
"""those of the lowest bins"""
LEAST_RECORDINGS = 8
LEAST_OF_A_SPEED = 3
LEAST_SPEEDS = 2
"""speeds at which a tone must be heard: at one speed an order is a tone, too"""
ORDER_BINS = 2.0
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
    turning_hz: float
    """output revolutions a second: orders stand at multiples of it"""


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


def longest_run(marked: NDArray[np.bool_]) -> tuple[int, int]:
    """Begin and end of the longest run of marked samples; an empty one where there is none."""
    runs = np.flatnonzero(np.diff(np.concatenate(([0], marked.astype(np.int8), [0])))).reshape(-1, 2)
    if runs.size == 0:
        return 0, 0
    a, b = runs[np.argmax(runs[:, 1] - runs[:, 0])].tolist()
    return a, b


def tone_spectrum(
    index: int,
    signal: FloatArray,
    valid: NDArray[np.bool_],
    steady: NDArray[np.bool_],
    rate: float,
    velocity: FloatArray,
) -> ToneSpectrum | None:
    """Spectrum of the longest steady run of a recording; None where that is shorter than two segments."""
    segment = round(SEGMENT_S * rate)
    a, b = longest_run(steady)
    if b - a < 2 * segment:
        return None
    # medians of a long recording need no more than some ten thousand of its samples
    few = slice(None, None, max(1, (b - a) // ENOUGH_SAMPLES))
    own = np.where(valid[a:b], signal[a:b], np.median(signal[a:b][few]))
    own -= np.median(own[few])
    limit = 6.0 * 1.4826 * float(np.median(np.abs(own[few]))) or 1.0
    np.clip(own, -limit, limit, out=own)
    frequency, power = welch(own, rate, window="hann", nperseg=segment, detrend="constant", scaling="density")
    turning = abs(float(np.median(velocity[a:b]))) / (2.0 * np.pi)
    keep = int(np.searchsorted(frequency, min(HIGHEST_HZ, 0.45 * rate)))
    power = power[:keep]
    background = surroundings(power)
    background[: FAR + 1] = surroundings(power, LOW_NEAR, LOW_FAR)[: FAR + 1]
    return ToneSpectrum(index, power / np.maximum(background, 1e-300), power - background, float(frequency[1]), turning)


def _without(spectrum: ToneSpectrum, orders: Sequence[float]) -> FloatArray:
    """Relative power with the bins of known orders taken out (not a number)."""
    out = spectrum.relative.copy()
    for order in orders:
        centre = order * spectrum.turning_hz / spectrum.bin_hz
        a, b = int(np.ceil(centre - ORDER_BINS)), int(np.floor(centre + ORDER_BINS)) + 1
        out[max(a, 0) : max(b, 0)] = np.nan
    return out


def at_every_speed(relative: FloatArray, turning: FloatArray) -> FloatArray:
    """Median over the recordings of each speed, the least but one of all; 0 where too few recordings say anything.

    Orders of different speeds meet at one frequency now and then (138 at 10 deg/s, 276 at 5); never at all speeds.
    """
    speed = np.round(turning / max(float(np.median(turning)), 1e-12), 1)
    medians: list[FloatArray] = []
    enough = np.sum(np.isfinite(relative), axis=0) >= LEAST_RECORDINGS
    for value in np.unique(speed):
        rows = relative[speed == value]
        if rows.shape[0] >= LEAST_OF_A_SPEED:
            heard = np.sum(np.isfinite(rows), axis=0) >= LEAST_OF_A_SPEED
            median = np.full(rows.shape[1], np.nan)
            median[heard] = np.nanmedian(rows[:, heard], axis=0)
            medians.append(median)
    overall = np.zeros(relative.shape[1])
    overall[enough] = np.nanmedian(relative[:, enough], axis=0)
    heard_at = np.sum([np.isfinite(median) for median in medians], axis=0) if medians else np.zeros(1)
    overall = np.where(heard_at >= LEAST_SPEEDS, overall, 0.0)
    if medians:
        # at one speed an unknown order may stand beside the tone and hide it
        place = 1 if len(medians) > 2 else 0
        lowest = np.sort(np.array(medians), axis=0)[place]
        overall = np.where(np.isfinite(lowest), np.minimum(overall, lowest), overall)
    return overall


def surroundings(power: FloatArray, near: int = NEAR, far: int = FAR) -> FloatArray:
    """Median power some bins to the left and to the right of each bin: the larger of the two, so that a slope is no
    peak.
    """
    padded = np.pad(power, far, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, far - near + 1)
    middle = np.median(windows, axis=1)
    left, right = middle[: power.size], middle[far + near : far + near + power.size]
    return np.asarray(np.maximum(left, right))


def search(spectra: Sequence[ToneSpectrum], orders: Sequence[float] = ()) -> list[Tone]:
    """Frequencies whose power stands out of its surroundings at every speed.

    ``orders`` are those known to be there (a revolution of the output): bins they reach say nothing about a tone.
    """
    if len(spectra) < LEAST_RECORDINGS:
        return []
    keep = min(s.relative.size for s in spectra)
    relative = np.array([_without(s, orders)[:keep] for s in spectra])
    middle = at_every_speed(relative, np.array([s.turning_hz for s in spectra]))
    usual = float(np.median(middle[LOWEST_BIN:]))
    if usual <= 0.0:  # one speed only: orders and tones cannot be told apart
        return []
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
        weight = np.nan_to_num(np.nanmean(relative[:, near], axis=0)) - usual
        weight = np.maximum(weight, 0.0)
        centre = float(np.sum(weight * np.arange(near.start, near.stop)) / max(float(weight.sum()), 1e-300)) * width
        amplitude = np.sqrt(2.0 * energy)
        spread_of = float(np.std(amplitude) / np.sqrt(amplitude.size))
        out.append(Tone(centre, float(np.median(amplitude)), spread_of, width, float(left[k] / usual), shown))
        left[max(k - 4, 0) : k + 5] = 0.0
    return out
