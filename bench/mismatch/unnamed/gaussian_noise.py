"""Gaussian noise with a memory: white noise and two first-order processes, in pieces whose offsets are not known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from bench.mismatch.unnamed.binned import LONGEST, Pieces, means
from bench.simulation.frame import FloatArray, IntArray

MEMORIES = (2.0, 8.0, 30.0, 100.0)
"""bins, time constants with which the fit begins"""


def best_likelihood(pieces: Pieces, enough: float) -> float:
    """Log-likelihood of the noise that fits some pieces best, the offsets integrated over all values; the first that
    reaches ``enough``.
    """
    seen = [np.flatnonzero(w > 0.0) for w in pieces.weight]
    data = [(k, v[k], 1.0 / w[k]) for k, v, w in zip(seen, pieces.values, pieces.weight, strict=True) if k.size > 1]
    total = float(np.sum(pieces.weight * (pieces.values - means(pieces.values, pieces.weight)[:, None]) ** 2))
    variance = total / float((pieces.weight > 0.0).sum())
    begins = [
        np.log([variance * (1.0 - share), variance * share, memory, 0.1 * variance * share, 4.0 * memory])
        for memory in MEMORIES
        for share in (0.3, 0.7)
    ]
    costs = [_cost(x, data) for x in begins]
    if -min(costs) >= enough:
        return -min(costs)
    found = minimize(
        _cost, begins[int(np.argmin(costs))], (data,), "Nelder-Mead", options={"maxfev": 250, "fatol": 0.1}
    )
    return -float(found.fun)


def _cost(x: FloatArray, data: Sequence[tuple[IntArray, FloatArray, FloatArray]]) -> float:
    """Minus the log-likelihood of white noise and two first-order processes, the offsets integrated over all values.

    ``x``: logarithms of the white variance, and of variance and time constant (bins) of each process.
    """
    white, first, memory, second, longer = np.exp(np.clip(x, -80.0, 80.0))
    out = 0.0
    lags = np.arange(LONGEST)
    course = first * np.exp(-lags / memory) + second * np.exp(-lags / longer)
    for at, values, noise in data:
        whole = course[np.abs(at[:, None] - at[None, :])]
        whole[np.diag_indices(at.size)] += white * noise
        try:
            factored = cho_factor(whole, lower=True, check_finite=False)
        except np.linalg.LinAlgError:
            return float("inf")
        one = cho_solve(factored, np.ones(at.size), check_finite=False)
        inside = cho_solve(factored, values, check_finite=False)
        level = float(one.sum())
        squares = float(values @ inside) - float(values @ one) ** 2 / level
        constants = 2.0 * float(np.log(np.diag(factored[0])).sum()) + np.log(level)
        out += 0.5 * (squares + constants + (at.size - 1) * np.log(2.0 * np.pi))
    return out
