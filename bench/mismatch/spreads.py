"""How far the offset's polynomial may bend: spread of its coefficients by the evidence of the recordings themselves.

Some twenty recordings a direction determine ten coefficients badly: free ones follow the noise and go astray at the
corners of the design that were held out. Linear coefficients (of speed and temperature) and those of second order get a
normal prior each, whose spread is where the marginal likelihood of all training recordings is highest (empirical
Bayes; MacKay, Neural Comput. 4 (1992) 415). The compliance and the constant stay free.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.bank import Bank
from bench.mismatch.columns import Layout
from bench.simulation.frame import FloatArray

SECOND_ORDER = (0, 1, 2, 6, 7, 8)
LINEAR = (4, 5)
MONOMIALS = 10
SPREADS = np.geomspace(0.003, 30.0, 13)
"""root mean square of what a coefficient contributes, in units of a block's noise, that is tried"""


def settle(bank: Bank, layout: Layout, chosen: Sequence[int] = ()) -> None:
    """Set the prior precision of the offset's coefficients in the bank; ``chosen`` columns are fitted beside them."""
    place = next((index for effect, _, index in layout.base_effects if effect == "te.offset"), None)
    if place is None:
        return
    # a direction in which the bench was never driven has columns without anything in them
    alive = np.any(layout.columns[:, list(place)] != 0.0, axis=0)
    groups = [
        np.array([i for k, i in enumerate(place) if k % MONOMIALS in group and alive[k]], dtype=np.int64)
        for group in (LINEAR, SECOND_ORDER)
    ]
    unit = np.zeros(bank.size)
    for group in groups:
        energy = np.mean((layout.columns[:, group] / bank.noise.sigma[:, None]) ** 2, axis=0)
        unit[group] = energy  # precision of a coefficient that contributes one sigma on average
    index = np.asarray(sorted({*layout.base, *chosen}), dtype=np.int64)
    best = -np.inf
    kept = bank.precision.copy()
    for variance in bank.noise.offset_variances:
        gram, cost = bank.marginal(index, variance)
        total = gram.sum(axis=0)
        for linear in SPREADS:
            for second in SPREADS:
                tried = bank.precision.copy()
                for group, spread in zip(groups, (linear, second), strict=True):
                    tried[group] = unit[group] / spread**2
                evidence = _evidence(total, tried[index], np.isin(index, np.concatenate(groups))) - 0.5 * cost.sum()
                if evidence > best:
                    best, kept = evidence, tried
    bank.precision = kept


def _evidence(total: FloatArray, precision: FloatArray, shrunk: NDArray[np.bool_]) -> float:
    """Logarithm of the marginal likelihood of ``total``, the Gram matrix of columns and y (p + 1, p + 1)."""
    p = precision.size
    energy = np.diag(total)[:p] + precision
    scale = np.sqrt(np.where(energy > 0.0, energy, 1.0))
    normal = total[:p, :p] / scale[:, None] / scale[None, :] + np.diag(precision / scale**2 + 1e-9)
    factor = np.linalg.cholesky(normal)
    half = np.linalg.solve(factor, total[:p, p] / scale)
    volume = np.sum(np.log(np.diag(factor))) + np.sum(np.log(scale))
    return float(-0.5 * (total[p, p] - half @ half) - volume + 0.5 * np.sum(np.log(precision[shrunk])))
