"""How large the largest of many values gets in noise: a Gumbel law through a sample of such maxima."""

from __future__ import annotations

import numpy as np

from bench.mismatch import criteria
from bench.simulation.frame import FloatArray


def tail(values: FloatArray, rate: float) -> float:
    """Value exceeded at a small ``rate``, by a Gumbel law fitted to a sample of maxima."""
    mode, scale = _gumbel(values)
    return float(mode - scale * np.log(-np.log1p(-rate)))


def tail_probability(values: FloatArray, value: float, least: float = criteria.LEAST_P) -> float:
    """Chance that a maximum like those sampled exceeds ``value``: their share (Davison and Hinkley 1997, eq. 4.11),
    beyond the largest of them by a Gumbel law.
    """
    above = float(np.sum(values >= value))
    if above > 0.0:
        return (1.0 + above) / (1.0 + values.size)
    mode, scale = _gumbel(values)
    beyond = float(-np.expm1(-np.exp(-min((value - mode) / scale, 700.0))))
    return float(np.clip(beyond, least, 1.0 / (1.0 + values.size)))


def _gumbel(values: FloatArray) -> tuple[float, float]:
    """Mode and scale of a Gumbel law through a sample's L-moments (Hosking, J. R. Stat. Soc. B 52 (1990) 105)."""
    ordered = np.sort(values)
    n = ordered.size
    second = float(np.sum((2.0 * np.arange(1, n + 1) - n - 1.0) * ordered) / (n * (n - 1.0)))
    scale = max(second / np.log(2.0), 1e-12)
    return float(ordered.mean()) - 0.5772156649 * scale, scale


def tail_rate(values: FloatArray, value: float) -> float:
    """Rate at which maxima exceed a value, by the same law."""
    low, high = tail(values, 0.5), tail(values, 0.01)
    scale = max((high - low) / (np.log(-np.log1p(-0.5)) - np.log(-np.log1p(-0.01))), 1e-12)
    mode = low + scale * np.log(-np.log1p(-0.5))
    return max(float(-np.expm1(-np.exp(-(value - mode) / scale))), criteria.LEAST_P)
