"""Errors that recordings of one level share: how large they are, and what they add to the variance of parameters.

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
"""Share of a level's error that the fit has to leave in the residuals, on average, for them to tell it."""


@dataclass(frozen=True, slots=True)
class _Means:
    """Recordings (R,): mean residual, relative variance of their own error, levels; what they add to x^T (R, P)."""

    residual: FloatArray
    own: FloatArray
    labels: tuple[IntArray, ...]
    sums: FloatArray
    mean: FloatArray


def _means(x: FloatArray, residual: FloatArray, group: IntArray, shared: Sequence[IntArray]) -> _Means | None:
    """Means over the rows of each recording that belong to a level (label ≥ 0) of every kind."""
    rows = np.all([labels >= 0 for labels in shared], axis=0)
    if not rows.any():
        return None
    first: IntArray
    index: IntArray
    _, first, index, count = np.unique(group[rows], return_index=True, return_inverse=True, return_counts=True)
    sums = np.stack([np.bincount(index, column) for column in x[rows].T], axis=1, dtype=np.float64)
    return _Means(
        np.bincount(index, residual[rows]) / count,
        count.mean() / count,
        tuple(labels[rows][first] for labels in shared),
        sums,
        sums / count[:, None],
    )


def shared_variance(
    x: FloatArray, inverse: FloatArray, residual: FloatArray, group: IntArray, shared: Sequence[IntArray]
) -> tuple[FloatArray, FloatArray]:
    """Variance (P,) that errors shared by levels add to parameters, and its degrees of freedom (P,).

    Parameters
    ----------
    x : (n, P) regressors; ``inverse`` (P, P) of their normal matrix; ``residual`` (n,) of the fit.
    group : (n,) recording of a row. shared : for each kind, (n,) level of a row, the same for all rows of a recording;
        negative where a row belongs to none.

    Returns
    -------
    Variances are 0, with infinitely many degrees, where the residuals show no shared error or cannot tell.
    """
    size = x.shape[1]
    nothing = np.zeros(size), np.full(size, np.inf)
    means = _means(x, residual, group, shared) if shared else None
    if means is None:
        return nothing
    kernels = [np.diag(means.own)]
    for labels in means.labels:
        if np.unique(labels).size >= FEW_LEVELS:
            kernels.append((labels[:, None] == labels[None, :]).astype(np.float64))
    left = np.eye(means.residual.size) - means.mean @ inverse @ means.sums.T
    seen = [left @ kernel @ left.T for kernel in kernels]
    told = [0] + [c for c in range(1, len(kernels)) if np.trace(seen[c]) > MIN_LEFT * np.trace(kernels[c])]
    squares = np.array([means.residual @ kernel @ means.residual for kernel in kernels])
    while len(told) > 1:
        moments = np.array([[np.sum(kernels[i] * seen[j]) for j in told] for i in told])
        back = np.linalg.pinv(moments)
        found = back @ squares[told]
        lowest = 1 + int(np.argmin(found[1:]))
        if found[lowest] > 0.0:
            break
        told.pop(lowest)
    if len(told) == 1:
        return nothing
    effect = inverse @ means.sums.T
    add = np.array([np.einsum("pr,rs,ps->p", effect, kernels[c], effect) for c in told[1:]])
    variance = found[1:] @ add
    covariance = sum(f * seen[c] for f, c in zip(found, told, strict=True))
    freedom = np.full(size, np.inf)
    for p, weights in enumerate(add.T @ back[1:]):
        # the variance is a quadratic form of the residuals: Satterthwaite's degrees of freedom
        form = sum(w * kernels[c] for w, c in zip(weights, told, strict=True)) @ covariance
        freedom[p] = np.trace(form) ** 2 / max(float(np.sum(form * form.T)), 1e-300)
    return variance, np.maximum(freedom, 1.0)
