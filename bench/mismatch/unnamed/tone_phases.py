"""The phase of a tone over the time of one recording, in blocks.

A spectrum says what frequency a tone has in the mean of its segments; the course of the phase says besides whether it
kept to it. A block's phase scatters by the noise about the line: where that has the mean square s² in the transform of
a block, and the line the size a, by s / (√2 a) (Rife, Boorstyn, IEEE Trans. Inform. Theory 20 (1974) 591).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.mismatch.recordings.vibration import Complex, Run, longest_run
from bench.simulation.frame import FloatArray

LENGTHS_S = (1.0, 2.0, 5.0, 10.0)
"""of the blocks: the shortest in which the phase is seen"""
SEEN = 0.25
"""rad, standard deviation of a block's phase that can be followed: a step of half a turn is then nine of that of a
difference"""
FINEST = 1e-4
"""rad, least standard deviation of a phase that is counted with: over a second it is 0.02 mHz"""
PERIODS = 4.0
"""of the tone in a block: a Hann window's line is two bins wide to either side, and so is that of a zero"""
FEWEST_BLOCKS = 3
"""of a course: two say nothing of how straight it is"""
FURTHEST = 2.0
"""bins to either side that the line of a Hann window reaches"""
ABOUT = 20
"""bins beyond these to either side whose median tells the noise"""
SHARED = 1.0 / 6.0
"""correlation of the noise of two blocks with Hann windows that overlap by half (Harris, Proc. IEEE 66 (1978) 51)"""


@dataclass(frozen=True, slots=True)
class Phases:
    """Phase (m,) of a tone less that of a frequency asked about, rad, at times (m,) since the run began, s, and its
    covariance by noise (m, m), rad².
    """

    time: FloatArray
    phase: FloatArray
    covariance: FloatArray


def phases(run: Run, frequency: float, most: int) -> Phases | None:
    """The course of the phase of a tone near a ``frequency`` (Hz) in at ``most`` so many blocks; None where it cannot
    be followed.
    """
    for length in LENGTHS_S:
        size = round(length * run.rate)
        if length * frequency < PERIODS or run.samples.size < (FEWEST_BLOCKS + 1) * (size // 2) + size % 2:
            continue
        lines, noise = _blocks(run, frequency, size)
        # half of the noise is across the vector
        spread = np.maximum(np.sqrt(0.5 * noise) / np.maximum(np.abs(lines), 1e-300), FINEST)
        a, b = longest_run(spread <= SEEN)
        if b - a >= FEWEST_BLOCKS and 2 * (b - a) > lines.size:
            time = np.asarray((np.arange(a, b) * (size // 2) + 0.5 * size) / run.rate, dtype=np.float64)
            return _fewer(time, np.unwrap(np.angle(lines[a:b])), spread[a:b], most)
    return None


def _blocks(run: Run, frequency: float, size: int) -> tuple[Complex, float]:
    """Transforms (blocks,) of blocks of ``size`` samples less their straight lines at a ``frequency``, and the mean
    square of the noise in them, by the median of the bins about it over all blocks.
    """
    bins, apart = run.rate / size, FURTHEST + np.arange(ABOUT)
    beside = frequency + bins * np.concatenate([-apart[::-1], apart])
    beside = beside[(beside > FURTHEST * bins) & (beside < 0.5 * run.rate - FURTHEST * bins)]
    turns = np.outer(np.arange(size) / run.rate, np.append(frequency, beside))
    wave = np.hanning(size)[:, None] * np.exp(-2j * np.pi * turns)
    straight = np.linalg.qr(np.column_stack([np.ones(size), np.arange(size)]))[0]
    wave -= straight @ (straight.T @ wave)
    parts = np.lib.stride_tricks.sliding_window_view(run.samples, size)[:: size // 2]
    # one after another: a long recording's blocks together would take many times its memory
    lines = np.array([part @ wave for part in parts])
    begin = np.exp(-2j * np.pi * frequency * (size // 2) / run.rate * np.arange(len(parts)))
    # the median of an exponential variable is ln 2 of its mean
    return lines[:, 0] * begin, float(np.median(np.abs(lines[:, 1:]) ** 2)) / np.log(2.0)


def _fewer(time: FloatArray, phase: FloatArray, spread: FloatArray, most: int) -> Phases:
    """A course in means of neighbouring blocks, where there are more than ``most``. ``spread``: standard deviations."""
    number = time.size
    near = np.eye(number) + SHARED * (np.eye(number, k=1) + np.eye(number, k=-1))
    covariance = spread[:, None] * near * spread
    groups = min(number, most)
    means = (np.arange(number) * groups // number == np.arange(groups)[:, None]).astype(np.float64)
    means /= means.sum(axis=1, keepdims=True)
    return Phases(means @ time, means @ phase, means @ covariance @ means.T)
