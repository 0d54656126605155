"""A test that may be looked at after every recording, for ever: evidence against "the model still holds".

A stream is one number of each recording, z, scaled so that while the model holds, whatever went before,

    (1) E[z | past] lies within ±``BIAS`` and E[z² | past] is at most 1.

For a bet λ the factor (1 + λz + λ²z²/2)/(1 + |λ|·BIAS + λ²/2) is positive and by (1) of expectation 1 at most, given
the past; so is 1 − κ + κz². (It is the wealth of a gambler; the first is the bound behind Catoni's influence function:
Wang and Ramdas, Stochastic Processes and their Applications 163 (2023) 168.) Nothing else is asked of z: neither a
normal distribution nor that recordings are independent. Products of such factors from any recording k on are test
supermartingales, and so is their mean over k with weights that sum to 1, over bets, and over streams, however streams
depend on each other. By Ville's inequality the mean ever reaches 1/α with a probability of α at most, be the campaign
as long as it may. This is a Shiryaev–Roberts sum made proper: weights over the time of the change, so that it bounds a
probability instead of a mean time (Shin, Ramdas and Rinaldo, "E-detectors", 2023).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

BIAS = 0.5
"""standard scales by which a model that holds may be off on the mean at the conditions of the next recording"""
BETS = (-2.0, -0.5, 0.5, 2.0)
"""λ: small ones win slowly and surely from small changes, large ones quickly from large ones"""
POWER_BETS = (0.25, 1.0)
"""κ: for changes of size, whatever their sign"""
FIRST = math.e
"""shifts the weights' logarithm so that they begin at 1"""


def weight(k: int) -> float:
    """Weight of a change at the k-th tested recording (k from 1): 1/log(k + e − 1) − 1/log(k + e); they sum to 1."""
    return 1.0 / math.log(k + FIRST - 1.0) - 1.0 / math.log(k + FIRST)


def weight_after(k: int) -> float:
    """Weight of all changes after the k-th tested recording."""
    return 1.0 / math.log(k + FIRST)


def factors(z: float, signed: bool) -> FloatArray:
    """log of each bet's factor (bets,) for one number; those of λ first where the stream has a sign."""
    square = z * z
    out = [1.0 - kappa + kappa * square for kappa in POWER_BETS]
    if signed:
        signed_factors = [(1.0 + b * z + 0.5 * b * b * square) / (1.0 + abs(b) * BIAS + 0.5 * b * b) for b in BETS]
        out = signed_factors + out
    return np.log(np.maximum(out, 1e-300))


@dataclass(slots=True)
class Evidence:
    """Evidence of one stream, in logarithms."""

    signed: bool
    taken: list[FloatArray] = field(default_factory=list)
    """log factors (bets,) of each recording that counted"""
    at: list[int] = field(default_factory=list)
    """number among the tested recordings of each of these, from 1"""
    _sum: FloatArray = field(default_factory=lambda: np.full(0, -np.inf))
    _rest: float = 1.0

    def add(self, z: float, number: int) -> None:
        """Take the number of the ``number``-th tested recording; recordings without one are left out."""
        log_factors = factors(z, self.signed)
        if self._sum.size == 0:
            self._sum = np.full(log_factors.size, -np.inf)
        # changes since the last recording that counted begin with this one
        started = math.log(self._rest - weight_after(number))
        self._rest = weight_after(number)
        self._sum = np.logaddexp(self._sum, started) + log_factors
        self.taken.append(log_factors)
        self.at.append(number)

    @property
    def log(self) -> float:
        """log of the evidence: mean over bets of the sum over times of the change."""
        if self._sum.size == 0:
            return 0.0
        each = np.logaddexp(self._sum, math.log(self._rest))
        return float(np.logaddexp.reduce(each) - math.log(each.size))

    def since(self) -> int | None:
        """Number of the tested recording from which the strongest bet wins most; None before any."""
        if not self.taken:
            return None
        gained = np.cumsum(np.array(self.taken)[::-1], axis=0)[::-1]
        place = int(np.unravel_index(int(np.argmax(gained)), gained.shape)[0])
        return self.at[place]


def combined_log(logs: FloatArray, weights: FloatArray) -> float:
    """log of the weighted mean of evidence of several streams (n,), weights (n,) of sum 1."""
    return float(np.logaddexp.reduce(logs + np.log(weights)))
