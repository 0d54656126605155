"""Linear regression whose unit of evidence is the recording, and which names what the data do not determine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MIN_OWN_SHARE = 0.01
"""A parameter is determined only if at least this share of its regressor's norm is not made up of the others'."""


@dataclass(frozen=True, slots=True)
class LinearFit:
    """Values and standard deviations by symbol; ``undetermined`` lists symbols left out; RMSE of the residual."""

    values: dict[str, float]
    std: dict[str, float]
    undetermined: tuple[str, ...]
    rmse: float
    rows: int


def regress(columns: Mapping[str, FloatArray], target: FloatArray, group: NDArray[np.int64]) -> LinearFit:
    """Least squares of ``target`` (n,) on named columns (n,), standard deviations clustered by ``group`` (n,).

    A column that is zero, or that the others make up but for 1 % of its norm, is left out and named. The covariance is
    the cluster-robust sandwich with the G/(G − 1) correction (Liang and Zeger 1986); with a single group, rows are
    taken in 20 consecutive batches instead.
    """
    names, missing = _independent(columns)
    if not names or target.size <= len(names):
        return LinearFit({}, {}, tuple(columns), float("nan"), int(target.size))
    x = np.column_stack([columns[name] for name in names])
    scale = np.linalg.norm(x, axis=0)
    x = x / scale
    inverse = np.linalg.inv(x.T @ x)
    solution = inverse @ (x.T @ target)
    residual = target - x @ solution
    if np.unique(group).size < 4:
        group = np.arange(target.size) * 20 // target.size
    _, cluster = np.unique(group, return_inverse=True)
    count = int(cluster.max()) + 1
    score = np.zeros((count, len(names)))
    for j in range(len(names)):
        score[:, j] = np.bincount(cluster, weights=x[:, j] * residual, minlength=count)
    covariance = inverse @ (score.T @ score) @ inverse * count / max(count - 1, 1)
    std = np.sqrt(np.diag(covariance)) / scale
    values = solution / scale
    return LinearFit(
        {name: float(v) for name, v in zip(names, values, strict=True)},
        {name: float(s) for name, s in zip(names, std, strict=True)},
        tuple(missing),
        float(np.sqrt(np.mean(residual**2))),
        int(target.size),
    )


def _independent(columns: Mapping[str, FloatArray]) -> tuple[list[str], list[str]]:
    """Split symbols into those whose column is told apart from all others' together, and the rest.

    Of columns that are alike the one that comes later is left out first, so callers list what matters most first.
    """
    names, missing = list(columns), [name for name in columns if not np.any(columns[name])]
    names = [name for name in names if name not in missing]
    while names:
        unit = np.column_stack([columns[name] / np.linalg.norm(columns[name]) for name in names])
        gram = unit.T @ unit
        inverse = np.linalg.pinv(gram, rcond=1e-12, hermitian=True)
        own = np.sqrt(1.0 / np.maximum(np.diag(inverse), 1.0))
        if np.linalg.matrix_rank(gram, tol=1e-10 * len(names), hermitian=True) < len(names):
            _, vectors = np.linalg.eigh(gram)
            own = np.where(np.abs(vectors[:, 0]) > 1e-3, 0.0, own)
        weak = [i for i in range(len(names)) if own[i] < MIN_OWN_SHARE]
        if not weak:
            break
        missing.append(names.pop(weak[-1]))
    return names, missing


def sentences(fit: LinearFit, meaning: Mapping[str, str], reasons: Mapping[str, str]) -> list[str]:
    """One sentence a parameter that was not determined: what it is and what recordings would determine it."""
    return [f"{symbol} ({meaning[symbol]}) is not determined: {reasons[symbol]}." for symbol in fit.undetermined]


def stack(parts: Sequence[FloatArray]) -> FloatArray:
    """Concatenate parts, an empty array where there are none."""
    return np.concatenate(parts) if parts else np.empty(0)
