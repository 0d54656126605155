"""The lowest place of a function of a few numbers, without its slope."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import minimize

from bench.simulation.frame import FloatArray


def lowest(function: Callable[[FloatArray], float], begin: FloatArray, steps: FloatArray, most: int) -> FloatArray:
    """Where a function is lowest (k,), from ``begin`` in first ``steps``, after ``most`` evaluations (Nelder and
    Mead).
    """
    options: dict[str, Any] = {
        "maxfev": most,
        "initial_simplex": begin + np.vstack([np.zeros(begin.size), np.diag(steps)]),
        "xatol": 1e-3,
        "fatol": 1e-2,
    }
    found = minimize(lambda x: float(function(np.asarray(x))), begin, method="Nelder-Mead", options=options)  # type: ignore[call-overload]
    return np.asarray(found.x, dtype=np.float64)
