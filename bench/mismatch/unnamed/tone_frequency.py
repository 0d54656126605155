"""The frequency of a tone by the courses of its phase in several recordings, and how sure it is.

The phase grows by the frequency, begins anywhere in each recording, and beside the noise about the line three things
may move it: each recording has another frequency (a variance), or the phase wanders, in each by itself or in all alike
with the time since they began (random walks: a variance a second each). Recordings that are alike do not show the last
by how they differ; its course does. None of the three variances is known. So the frequency is estimated with each
combination of them on a grid: none, and standard deviations with equal ratios, which is Jeffreys' prior of a scale. The
estimates are weighted by the restricted likelihood (Box, Tiao, Bayesian Inference in Statistical Analysis, 1973, ch. 5;
Harville, Biometrika 61 (1974) 383). With few recordings the result has the wide tails of a Student distribution.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag, cho_factor, cho_solve
from scipy.optimize import brentq
from scipy.stats import norm

from bench.mismatch.recordings.vibration import Run
from bench.mismatch.unnamed.tone_phases import Phases, phases
from bench.simulation.frame import FloatArray

FEWEST = 2
"""courses of the phase, of recordings: one alone says nothing of what differs between them"""
MOST_BLOCKS = 24
"""a recording: a course in more says no more of a frequency"""
MOST_ALTOGETHER = 240
"""blocks: what is calculated grows with the third power"""
MOST_RECORDINGS = 40
"""each has six blocks then"""
RATIO = 3.0
"""from one standard deviation of the grid to the next"""
ABSENT = 0.5 ** (1.0 / 3.0)
"""probability that one of the three is not there: none is as likely as some"""
LEAST = 0.3
"""smallest standard deviation of the grid over what noise alone makes of a slope: it adds a tenth to its variance"""
BEYOND = 3.0
"""largest over what the courses show"""
SURE = 0.95
"""share of the distribution in the interval that a standard deviation is told for"""


@dataclass(frozen=True, slots=True)
class Frequency:
    """Frequency in Hz. ``std``: half the 95 % interval over that of a normal distribution of variance 1."""

    value: float
    std: float


def frequency_of(runs: Sequence[Run], near: float) -> Frequency | None:
    """Frequency of a tone ``near`` one (Hz), in the runs of at most :data:`MOST_RECORDINGS`; None where the phase can
    be followed in fewer than :data:`FEWEST`.
    """
    most = min(MOST_ALTOGETHER // max(len(runs), 1), MOST_BLOCKS)
    courses = [found for run in runs if (found := phases(run, near, most)) is not None]
    if len(courses) < FEWEST:
        return None
    slopes, deviations, weights = _estimates(courses)
    middle, usual = float(weights @ slopes), float(norm.ppf(0.5 * (1.0 + SURE)))

    def missing(half: float) -> float:
        ends = [norm.cdf((middle + sign * half - slopes) / deviations) for sign in (-1.0, 1.0)]
        return SURE - float(weights @ (ends[1] - ends[0]))

    half = float(brentq(missing, 0.0, float(np.max(np.abs(slopes - middle) + 2.0 * usual * deviations))))
    return Frequency(near + middle / (2.0 * np.pi), half / usual / (2.0 * np.pi))


def _estimates(courses: Sequence[Phases]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Slope of the phase, its standard deviation (rad/s) and the weight of each combination of the variances."""
    time = np.concatenate([c.time for c in courses])
    phase = np.concatenate([c.phase for c in courses])
    noise = block_diag(*(c.covariance for c in courses))
    own = block_diag(*(np.ones((c.time.size, c.time.size)) for c in courses))
    design = np.column_stack([time, block_diag(*(np.ones((c.time.size, 1)) for c in courses))])
    together = np.minimum(time[:, None], time)
    length = float(np.median([np.ptp(c.time) for c in courses]))
    left = phase - design @ np.linalg.lstsq(design, phase, rcond=None)[0]
    # of a straight course: the square of a slope b over a length T is b² T² / 12 in the mean
    shown = float(np.sqrt(12.0 * np.mean(left**2))) / length
    each = float(np.sqrt(np.median([_slope_variance(c) for c in courses])))
    # what they have in common is no less in their mean
    levels = [_levels(each, shown), _levels(each, shown), _levels(each / np.sqrt(len(courses)), shown)]
    parts = (own * np.outer(time, time), own * together / length, together / length)
    out = []
    for deviations in itertools.product(*levels):
        covariance = noise + sum(d**2 * part for d, part in zip(deviations, parts, strict=True))
        slope, variance, likelihood = _fitted(phase, design, covariance)
        prior = [
            ABSENT if d == 0.0 else (1.0 - ABSENT) / (of.size - 1) for d, of in zip(deviations, levels, strict=True)
        ]
        out.append((slope, variance, likelihood + float(np.sum(np.log(prior)))))
    slopes, variances, likelihood = np.array(out).T
    weights = np.exp(likelihood - likelihood.max())
    return slopes, np.sqrt(variances), weights / weights.sum()


def _levels(noise: float, shown: float) -> FloatArray:
    """Standard deviations of the grid, rad/s: none, and from less than ``noise`` makes of a slope to more than is
    ``shown``.
    """
    number = int(np.ceil(np.log(BEYOND * max(shown / noise, 1.0) / LEAST) / np.log(RATIO))) + 1
    return np.append(0.0, LEAST * noise * RATIO ** np.arange(number))


def _slope_variance(course: Phases) -> float:
    """Variance of the slope of one course by noise alone, (rad/s)²."""
    design = np.column_stack([course.time, np.ones(course.time.size)])
    return _fitted(course.phase, design, course.covariance)[1]


def _fitted(phase: FloatArray, design: FloatArray, covariance: FloatArray) -> tuple[float, float, float]:
    """Coefficient of the first column of a ``design``, its variance, and the logarithm of the restricted likelihood."""
    factor = cho_factor(covariance, lower=True)
    weighted = cho_solve(factor, design)
    normal = cho_factor(design.T @ weighted, lower=True)
    coefficients = cho_solve(normal, weighted.T @ phase)
    left = phase - design @ coefficients
    first = np.eye(1, design.shape[1])[0]
    variance = float(cho_solve(normal, first)[0])
    squares = float(left @ cho_solve(factor, left))
    determinants = float(np.sum(np.log(np.diag(factor[0]))) + np.sum(np.log(np.diag(normal[0]))))
    return float(coefficients[0]), variance, -0.5 * squares - determinants
