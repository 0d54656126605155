"""Is the torque reading a torque? Checks over blocks that a ±10 V signal cannot make of itself.

A broken wire on ±10 V reads some voltage within range, mostly near zero; only other signals give it away. Three checks
look every cycle, each with the state it needs from the block before:

frozen
    the same count for a while although the shaft turns (sensor noise and torque ripple change it every few cycles);
at odds
    smoothed reading and expectation (load motor torque, friction, inertia) further apart than allowed, for a while;
drifting
    the slow mean of that difference away from what it was at first: an offset that grows, of sensor or amplifier.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.runs import run_lengths

_LARGEST_EXPONENT = 200.0
"""e^200 = 7e86: far from the largest double, 1.8e308, whatever torque it multiplies."""


@dataclass(frozen=True, slots=True)
class PlausibilityLimits:
    """What is still plausible.

    Attributes
    ----------
    frozen_s : time of equal readings while turning, s.
    disagreement_nm, disagreement_fraction : allowed difference, N·m plus a fraction of the expected torque.
    disagreement_s : time it may last, s.
    smoothing_s : time constant that takes the torque ripple out of both, s.
    drift_nm : allowed change of the slow mean difference, N·m.
    drift_window_s : time constant of the slow mean, s; the first such time of a run is its reference.
    """

    frozen_s: float = 0.5
    disagreement_nm: float = 100.0
    disagreement_fraction: float = 0.05
    disagreement_s: float = 0.2
    smoothing_s: float = 0.1
    drift_nm: float = 50.0
    drift_window_s: float = 60.0


@dataclass(frozen=True, slots=True)
class Findings:
    """Masks (n,) of one block.

    Attributes
    ----------
    frozen, at_odds, drifting : cycles in which the check failed.
    difference_nm : smoothed reading minus smoothed expectation, N·m.
    """

    frozen: NDArray[np.bool_]
    at_odds: NDArray[np.bool_]
    drifting: NDArray[np.bool_]
    difference_nm: NDArray[np.float64]

    @property
    def plausible(self) -> NDArray[np.bool_]:
        """Mask (n,) of cycles in which every check passed."""
        return ~(self.frozen | self.at_odds | self.drifting)

    def text(self, name: str = "torque sensor") -> str | None:
        """Sentence on the first check that failed in this block; None where none did."""
        worst = float(self.difference_nm[np.argmax(np.abs(self.difference_nm))])
        for mask, what in (
            (self.frozen, "does not change although the shaft turns; check sensor supply and wiring"),
            (self.at_odds, f"is {worst:.4g} N·m away from what the load motor says; check wiring, taring and coupling"),
            (self.drifting, "drifts against the load motor; tare again and check sensor and amplifier"),
        ):
            if mask.any():
                return f"{name}: the reading {what}"
        return None


class PlausibilityMonitor:
    """The checks with their state from block to block.

    Parameters
    ----------
    limits : what is plausible.
    cycle_time_s : period of the samples, s.
    """

    def __init__(self, limits: PlausibilityLimits, cycle_time_s: float) -> None:
        self._limits = limits
        self._cycle_time_s = cycle_time_s
        self.reset()

    def reset(self) -> None:
        """Forget everything: after taring, or when a run begins."""
        self._last_count: int | None = None
        self._frozen_run = 0
        self._odds_run = 0
        self._fast: float | None = None
        self._slow: float | None = None
        self._age = 0
        self._reference: float | None = None

    def update(
        self,
        counts: NDArray[np.integer],
        torque_nm: NDArray[np.float64],
        expected_nm: NDArray[np.float64],
        turning: NDArray[np.bool_],
    ) -> Findings:
        """Look at the next block.

        Parameters
        ----------
        counts : readings (n,), counts as the terminal gave them.
        torque_nm : the same, N·m.
        expected_nm : torque (n,) that the other signals lead to expect, N·m.
        turning : mask (n,) of cycles in which the shaft turns.
        """
        difference = self._smooth(torque_nm - expected_nm)
        return Findings(
            self._frozen(counts, turning),
            self._at_odds(difference, expected_nm),
            self._drifting(difference),
            difference,
        )

    def _frozen(self, counts: NDArray[np.integer], turning: NDArray[np.bool_]) -> NDArray[np.bool_]:
        before = counts[:1] if self._last_count is None else np.array([self._last_count], counts.dtype)
        same = np.diff(counts, prepend=before) == 0
        runs = run_lengths(same & turning, self._frozen_run)
        self._last_count, self._frozen_run = int(counts[-1]), int(runs[-1])
        return np.greater_equal(runs, self._cycles(self._limits.frozen_s))

    def _at_odds(self, difference: NDArray[np.float64], expected: NDArray[np.float64]) -> NDArray[np.bool_]:
        limits = self._limits
        allowed = limits.disagreement_nm + limits.disagreement_fraction * np.abs(expected)
        runs = run_lengths(np.abs(difference) > allowed, self._odds_run)
        self._odds_run = int(runs[-1])
        return np.greater_equal(runs, self._cycles(limits.disagreement_s))

    def _drifting(self, difference: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Compare the slow mean with its value once one window has passed; before that nothing can be said."""
        window = self._cycles(self._limits.drift_window_s)
        slow, self._slow = self._low_pass(difference, self._limits.drift_window_s, self._slow)
        rows_until_reference = window - self._age
        self._age = min(self._age + len(difference), window)
        if self._reference is None:
            if rows_until_reference > len(slow):
                return np.zeros(len(slow), np.bool_)
            self._reference = float(slow[rows_until_reference - 1])
            after = np.arange(len(slow)) >= rows_until_reference
            return after & (np.abs(slow - self._reference) > self._limits.drift_nm)
        return np.greater(np.abs(slow - self._reference), self._limits.drift_nm)

    def _smooth(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        smooth, self._fast = self._low_pass(values, self._limits.smoothing_s, self._fast)
        return smooth

    def _low_pass(
        self, values: NDArray[np.float64], time_constant_s: float, last: float | None
    ) -> tuple[NDArray[np.float64], float]:
        """First-order low-pass y[k] = a·y[k−1] + (1−a)·x[k], a = exp(−Δt/T), starting at the first value."""
        step = self._cycle_time_s / time_constant_s
        at = float(values[0]) if last is None else last
        smooth = np.empty(len(values))
        # In closed form, y[k] = a^(k+1)·y[−1] + (1−a)·a^k·Σ x[j]·a^(−j); in pieces, so that a^(−j) stays finite. A
        # library does the same; importing it takes longer than everything else that opens a bench.
        longest = max(1, int(_LARGEST_EXPONENT / step))
        for first in range(0, len(values), longest):
            piece = values[first : first + longest]
            decay = np.exp(-step * np.arange(len(piece)))
            smooth[first : first + longest] = decay * (
                math.exp(-step) * at - math.expm1(-step) * np.cumsum(piece / decay)
            )
            at = float(smooth[first + len(piece) - 1])
        return smooth, at

    def _cycles(self, seconds: float) -> int:
        return max(1, round(seconds / self._cycle_time_s))
