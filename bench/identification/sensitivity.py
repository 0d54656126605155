"""Parameter sensitivities as the paper defines them: the change of a parameter that doubles the model's error.

With e the error over the identification recordings and g_i the change of the model per unit of parameter i, a change Δ
makes the mean square E² + Δ²·⟨g_i²⟩ (e and g_i are orthogonal where least squares left them), so Δ = E·√(3/⟨g_i²⟩).
The inputs are standardised, as in the fit; a large Δ is a small sensitivity.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bench.identification.series.inputs import Design
from bench.simulation import TERM_COUNT, FourierSet, basis

FloatArray = NDArray[np.float64]


def doubling_changes(fourier: FourierSet, design: Design, rmse: float) -> dict[str, FloatArray]:
    """Changes Δ of ``A`` (K, 10) and ``a0`` (10,) in rad and ``phi`` (K, 10) in rad; NaN where not determined.

    ``rmse`` is E in rad over the identification recordings of this direction.
    """
    x = design.standardisation.basis(design.inputs[:, 0], design.inputs[:, 1], design.inputs[:, 2])
    x = np.where(np.isin(np.arange(TERM_COUNT), design.kept)[None, :], x, np.nan)
    raw = basis(design.inputs[:, 0], design.inputs[:, 1], design.inputs[:, 2])
    level = raw @ fourier.amplitude.T
    root = rmse * np.sqrt(3.0)
    square = np.mean(x**2, axis=0)
    # ⟨sin²⟩ = ½ over a revolution; a phase acts through the amplitude.
    phase_square = 0.5 * np.einsum("rk,ri->ki", level**2, x**2) / x.shape[0]
    return {
        "A": np.tile(root / np.sqrt(0.5 * square), (fourier.orders.size, 1)),
        "phi": root / np.sqrt(np.maximum(phase_square, 1e-300)),
        "a0": root / np.sqrt(square),
    }
