"""A tone that is heard at some speeds and not at others: lines of one frequency at more speeds than chance puts there.

Lines that nobody knows, orders of neighbours among them, stand in every spectrum, at another frequency at each speed.
How often a spectrum is as loud at a frequency is counted in its octave, over all speeds; that several are so at one and
the same frequency has the chance of a binomial law. No law of the noise is needed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

from bench.simulation.frame import FloatArray, IntArray

SPEEDS = 3
"""different speeds that must have been driven for a tone to be told from an order"""
MOST = 0.5
"""of the speeds: a tone at more of them is one at most speeds"""
STEP = 1.4
"""from one number of speeds that is asked for to the next: a square root of two"""


@dataclass(frozen=True, slots=True)
class SomeSpeeds:
    """``frequency``: index of it; ``least`` power over the noise there, with which it is loud; the chance of that at so
    many speeds.
    """

    frequency: int
    least: float
    p_value: float


def at_some_speeds(loud: FloatArray, bins: IntArray) -> SomeSpeeds | None:
    """The least likely frequency that some speeds have in common; None where there are too few speeds.

    ``loud`` (speeds, frequencies): power over the noise about it, NaN where it was not seen; ``bins`` (frequencies,) of
    the spectrum, from its first, 0 Hz.
    """
    counts = _numbers(loud.shape[0])
    if not counts or not np.isfinite(loud).any():
        return None
    # the loudest first, those that were not seen last
    ordered = -np.sort(np.where(np.isfinite(loud), -loud, np.inf), axis=0)
    seen = np.isfinite(loud).sum(axis=0)
    octave = np.floor(np.log2(np.maximum(bins, 1))).astype(np.int64)
    chance = np.ones((len(counts), loud.shape[1]))
    for one in np.unique(octave):
        inside = np.flatnonzero(octave == one)
        values = loud[:, inside]
        values = np.sort(values[np.isfinite(values)])
        if values.size == 0:
            continue
        for row, count in enumerate(counts):
            least = ordered[count - 1, inside]
            share = (values.size - np.searchsorted(values, least, side="left")) / values.size
            chance[row, inside] = np.where(np.isfinite(least), binom.sf(count - 1, seen[inside], share), 1.0)
    row, frequency = divmod(int(np.argmin(chance)), chance.shape[1])
    p_value = min(float(chance[row, frequency]) * chance.size, 1.0)
    return SomeSpeeds(frequency, float(ordered[counts[row] - 1, frequency]), p_value)


def _numbers(speeds: int) -> list[int]:
    """How many speeds of so many are asked to have a frequency in common."""
    out: list[int] = []
    number = float(SPEEDS)
    while round(number) <= MOST * speeds:
        out.append(round(number))
        number *= STEP
    return out
