"""Errors that recordings of one level share: how large they are, and what they add to the covariance of parameters.

The mean of each recording's residual is ε_r + Σ_c u_c(level of r): a part of its own and one for each way in which
recordings share a level (a speed, a torque). The sums of squares of these means, over recordings and over levels, tell
the variances of the parts (method of moments; Rao 1972, "MINQUE(0)"), with what the fit has absorbed taken into
account.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

FEW_LEVELS = 4
"""With fewer levels than these nothing is said of an error that they share."""
MIN_LEFT = 0.02
"""Share of a level's error that the fit has to leave in the residuals, on average, for them to determine it."""


@dataclass(frozen=True, slots=True)
class Means:
    """Mean values of the R recordings of a linear fit.

    ``residual`` (R,) and ``regressors`` (R, P) are the means; ``variance`` (R,) is the variance of each recording's own
    error divided by the average of these; ``effect`` (P, R) is the effect of an error of each mean on the parameters.
    """

    residual: FloatArray
    variance: FloatArray
    regressors: FloatArray
    effect: FloatArray

    @classmethod
    def of_rows(
        cls, x: FloatArray, inverse: FloatArray, residual: FloatArray, group: IntArray, shared: Sequence[IntArray]
    ) -> tuple[Means, list[IntArray]] | None:
        """Means over the rows of each recording that belong to a level (label ≥ 0) of every kind, and their levels.

        ``x`` (n, P) regressors with the ``inverse`` (P, P) of their normal matrix, ``residual`` (n,), ``group`` (n,)
        recordings; ``shared`` for each kind (n,) labels. None where no row belongs to levels.
        """
        rows = np.all([labels >= 0 for labels in shared], axis=0) if shared else np.zeros(group.size, dtype=bool)
        if not rows.any():
            return None
        _, first, index, count = np.unique(group[rows], return_index=True, return_inverse=True, return_counts=True)
        sums = np.stack([np.bincount(index, column) for column in x[rows].T], axis=1, dtype=np.float64)
        mean = np.bincount(index, residual[rows]) / count
        means = cls(mean, count.mean() / count, sums / count[:, None], inverse @ sums.T)
        return means, [labels[rows][first] for labels in shared]


def shared_covariance(means: Means, kinds: Sequence[IntArray]) -> tuple[FloatArray, FloatArray]:
    """Covariance (P, P) that errors shared by levels add to parameters, and degrees of freedom (P,) of its variances.

    ``kinds`` are (R,) levels of the recordings, an array each. The covariance is 0, with infinitely many degrees, where
    the residuals show no shared error or do not determine it.
    """
    size = means.effect.shape[0]
    nothing = np.zeros((size, size)), np.full(size, np.inf)
    kernels = [np.diag(means.variance)]
    kernels += [(k[:, None] == k[None, :]).astype(np.float64) for k in kinds if np.unique(k).size >= FEW_LEVELS]
    left = np.eye(means.residual.size) - means.regressors @ means.effect
    seen = [left @ kernel @ left.T for kernel in kernels]
    determined = [0] + [c for c in range(1, len(kernels)) if np.trace(seen[c]) > MIN_LEFT * np.trace(kernels[c])]
    squares = np.array([means.residual @ kernel @ means.residual for kernel in kernels])
    while len(determined) > 1:
        moments = np.array([[np.sum(kernels[i] * seen[j]) for j in determined] for i in determined])
        back = np.linalg.pinv(moments)
        found = back @ squares[determined]
        lowest = 1 + int(np.argmin(found[1:]))
        if found[lowest] > 0.0:
            break
        determined.pop(lowest)
    if len(determined) == 1:
        return nothing
    add = np.array([means.effect @ kernels[c] @ means.effect.T for c in determined[1:]])
    covariance = np.einsum("c,cij->ij", found[1:], add)
    errors = sum(f * seen[c] for f, c in zip(found, determined, strict=True))
    freedom = np.full(size, np.inf)
    for p, weights in enumerate(np.einsum("cpp->pc", add) @ back[1:]):
        # the variance is a quadratic form of the residuals: Satterthwaite's degrees of freedom
        form = sum(w * kernels[c] for w, c in zip(weights, determined, strict=True)) @ errors
        freedom[p] = np.trace(form) ** 2 / max(float(np.sum(form * form.T)), 1e-300)
    return covariance, np.maximum(freedom, 1.0)
