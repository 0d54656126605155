"""The paper's second step: polynomials through amplitudes, phases and offsets of single recordings, as printed.

Inputs are the recordings' means, standardised; ordinary least squares for each A_k, φ_k and a₀, no weights, phases as
atan2 gave them (not unwrapped: the paper says nothing of it); coefficients scaled back to the raw inputs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.identification.samples.reduction import Reduction
from bench.identification.series.inputs import make_design
from bench.simulation import FourierSet


def identify_paper(reductions: Sequence[Reduction], orders: Sequence[float]) -> FourierSet | None:
    """Identify one direction from its recordings; None without any. Polynomial terms not determined stay 0."""
    used = [(r.paper, r.steady) for r in reductions if r.paper is not None and r.steady is not None]
    if not used:
        return None
    inputs = np.array([[s.torque.mean(), s.velocity.mean(), s.temperature.mean()] for _, s in used])
    design = make_design(inputs)
    targets = np.concatenate(
        [
            np.stack([h.amplitude for h, _ in used]),
            np.stack([h.phase for h, _ in used]),
            np.array([[h.offset] for h, _ in used]),
        ],
        axis=1,
    )
    solution = np.linalg.lstsq(design.regressors, targets, rcond=None)[0]
    raw = design.to_raw(solution.T)
    size = len(orders)
    return FourierSet(np.asarray(orders, dtype=np.float64), raw[:size], raw[size : 2 * size], raw[2 * size])
