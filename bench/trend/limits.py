"""Limits of control that take the uncertainty of every identification into account.

A gearbox is not quite the same in every campaign (mounting, lubricant), and every identification errs by its own
standard deviation: x_i = μ + u_i + e_i with u_i ~ N(0, τ²) and e_i ~ N(0, s_i²). The limits of a campaign are the
prediction interval of this random-effects model from the campaigns before it, widened by its own standard deviation:

    μ̂ ± t_ν(1 − α/2)·√(τ̂² + SE(μ̂)² + s²)

τ² is that of Paule and Mandel (1982, J. Res. NBS 87:377), the interval that of Higgins, Thompson and Spiegelhalter
(2009, J. R. Stat. Soc. A 172:137), α is Shewhart's (three standard deviations). ν is Satterthwaite's for the whole
variance: of few campaigns τ̂² is hardly known, least where chance made it nothing, and s has its own degrees of freedom.
Where all s_i are small this is Shewhart's chart of individuals with limits for few campaigns; where they differ, his
chart whose limits differ from point to point (Montgomery, Introduction to Statistical Quality Control, 6.3).

A gearbox that stays as it is falls outside with 0.28 % of its campaigns or less, a quantity (4000 simulated charts
each of 3 to 12 earlier campaigns, s_i between 0.5 and 2 known with 9 degrees of freedom, τ of 0, 0.5 and 2).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import norm, t

from bench.trend.quantities import Value

FloatArray = NDArray[np.float64]

ALPHA = float(2.0 * norm.sf(3.0))
"""A campaign of a gearbox that stays as it is falls outside with this chance, a quantity: 0.27 %."""
LEAST = 3
"""So many campaigns have to be there before limits are drawn: from two, scatter is hardly known."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Centre and limits for one campaign, in the unit of the values; ``scatter`` is τ, the campaigns' own.

    ``campaigns`` is how many earlier ones they rest on.
    """

    centre: float
    lower: float
    upper: float
    scatter: float
    campaigns: int


def scatter_between(values: FloatArray, std: FloatArray) -> float:
    """Return Paule and Mandel's τ² of values (k,) with standard deviations (k,); 0 where these explain everything."""
    if values.size < 2:
        return 0.0

    def excess(square: float) -> float:
        weight = 1.0 / (std**2 + square)
        mean = float(weight @ values / weight.sum())
        return float(weight @ (values - mean) ** 2) - (values.size - 1)

    spread = float(np.var(values, ddof=1))
    # the generalised Q falls with τ²; at the plain variance of the values it is below its expectation
    if spread == 0.0 or excess(1e-12 * spread) <= 0.0:
        return 0.0
    return float(brentq(excess, 1e-12 * spread, 2.0 * spread))


def limits_from(earlier: Sequence[Value], new: Value, alpha: float = ALPHA) -> Limits | None:
    """Return the limits for a new value from the earlier ones, None from fewer than three.

    Standard deviations have to be positive: a value without one has no place here.
    """
    if len(earlier) < LEAST:
        return None
    values = np.array([one.value for one in earlier])
    std = np.array([one.std for one in earlier])
    square = scatter_between(values, std)
    weight = 1.0 / (std**2 + square)
    centre = float(weight @ values / weight.sum())
    between = square + 1.0 / float(weight.sum())
    total = between + new.std**2
    # half the variance of τ̂² over T²: what is not seen of the scatter, also where chance made τ̂² nothing
    unseen = len(earlier) / (len(earlier) - 1) / float((weight**2).sum()) / total**2
    share = unseen + (new.std**2 / total) ** 2 / new.freedom
    half = float(t.isf(alpha / 2.0, 1.0 / share)) * math.sqrt(total)
    return Limits(centre, centre - half, centre + half, math.sqrt(square), len(earlier))


def chance_of_change(before: Value, after: Value) -> float:
    """Return the chance of a difference as large where nothing changed: Welch's t of the two standard deviations."""
    total = before.std**2 + after.std**2
    share = (before.std**2 / total) ** 2 / before.freedom + (after.std**2 / total) ** 2 / after.freedom
    ratio = abs(after.value - before.value) / math.sqrt(total)
    return float(2.0 * (t.sf(ratio, 1.0 / share) if share > 0.0 else norm.sf(ratio)))
