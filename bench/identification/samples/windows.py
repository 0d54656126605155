"""Which samples of a recording identification uses, and one sentence for each that it cannot."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bench.recording import Recording

FloatArray = NDArray[np.float64]

GAP_REVOLUTIONS = 0.01
"""A gap that spans more of the output's revolution than this splits a steady segment."""
REVOLUTION = 2.0 * np.pi


@dataclass(frozen=True, slots=True)
class Skipped:
    """Something that was not used, and why, in one sentence."""

    recording: str
    why: str


@dataclass(frozen=True, slots=True)
class SteadyWindow:
    """A stretch of steady motion over whole revolutions: samples ``start`` to ``stop``, ``direction`` ±1.

    ``segment_start`` and ``segment_stop`` bound the whole contiguous stretch of the steady segment it was taken from.
    """

    start: int
    stop: int
    segment_start: int
    segment_stop: int
    direction: int
    revolutions: int


def counting_bias(advance: float, samples: int) -> float:
    """Standard deviation, in counts, of the mean error that reading whole counts leaves at constant speed.

    ``advance`` is the encoder's counts a sample. Where it is close to a fraction p/q the counts' edges are met at q
    phases only, over and over: the mean of the rounding error is then not 0 but anything up to half of 1/q. Where the
    phase creeps through more than 1/q over the ``samples``, it has met all phases.
    """
    for q in range(1, samples + 1):
        # The speed itself is known to about a count over the recording.
        if abs(advance * q - round(advance * q)) * samples < 1.0 + 1.5 * q:
            return float(1.0 / (q * np.sqrt(12.0)))
    return 0.0


def lost_cycles(cycle: NDArray[np.int64]) -> tuple[NDArray[np.int64], int]:
    """Return the samples before which ``cycle`` steps by more than usual, and how many cycles are lost in all."""
    if cycle.size < 2:
        return np.empty(0, dtype=np.int64), 0
    step = np.diff(cycle)
    usual = int(np.median(step))
    where = np.flatnonzero(step > usual)
    lost = int((step[where] // max(usual, 1) - 1).sum())
    return where + 1, lost


def _contiguous(theta: FloatArray, part: slice) -> list[tuple[int, int]]:
    """Split a segment where the angle jumps by more than a small part of a revolution."""
    jump = np.flatnonzero(np.abs(np.diff(theta[part])) > GAP_REVOLUTIONS * REVOLUTION) + 1 + part.start
    edges = [part.start, *jump.tolist(), part.stop]
    return [(a, b) for a, b in pairwise(edges) if b > a]


def steady_window(recording: Recording, theta: FloatArray) -> SteadyWindow | str:
    """Find the steady stretch with the most whole revolutions; a sentence where there is none.

    ``theta`` is the input angle in load-side scaling, (N,) rad. The window ends where the segment ends and begins a
    whole number of revolutions earlier: integer orders are then orthogonal whatever else the error contains.
    """
    name = recording.recording_id
    parts = recording.steady()
    if not parts:
        return f"{name}: has no steady segment; identification of the transmission error needs one."
    best: SteadyWindow | None = None
    longest = 0.0
    for part in parts:
        for start, stop in _contiguous(theta, part):
            travel = theta[stop - 1] - theta[start]
            travelled = abs(travel) / REVOLUTION
            longest = max(longest, travelled)
            # Half a sample more on each side belongs to the stretch, so a whole revolution of N samples counts as one.
            revolutions = int(np.floor(travelled * (1.0 + 1.0 / max(stop - start - 1, 1)) + 1e-6))
            if revolutions < 1 or (best is not None and revolutions <= best.revolutions):
                continue
            sign = 1 if travel > 0 else -1
            # The angle is monotonic but for the encoder's noise; the first sample inside counts.
            inside = sign * (theta[stop - 1] - theta[start:stop]) < revolutions * REVOLUTION
            first = start + int(np.argmax(inside))
            best = SteadyWindow(first, stop, start, stop, sign, revolutions)
    if best is None:
        return (
            f"{name}: its longest gapless steady stretch covers {longest:.2f} of a revolution; at least one is needed "
            "for the transmission error."
        )
    return best
