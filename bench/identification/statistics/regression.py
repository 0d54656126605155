"""Linear regression whose unit of evidence is the recording, and which names what the data do not determine."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bench.identification.statistics.shared import Means, shared_covariance

FloatArray = NDArray[np.float64]

FEW_GROUPS = 4
"""With fewer recordings than these, rows are taken in batches instead."""
BATCHES = 20
MIN_INDEPENDENT_SHARE = 0.01
"""A parameter is determined only if at least this share of its regressor's norm is not made up of the others'."""


@dataclass(frozen=True, slots=True)
class LinearFit:
    """Values and standard deviations by symbol; ``undetermined`` lists symbols left out; RMSE of the residual.

    ``freedom`` has by symbol the degrees of freedom of the standard deviation (:mod:`.freedom`), ``systematic`` a
    further one that all recordings of a bench share (:mod:`bench.identification.balances.instant`).
    """

    values: dict[str, float]
    std: dict[str, float]
    undetermined: tuple[str, ...]
    rmse: float
    rows: int
    freedom: dict[str, float] = field(default_factory=dict)
    systematic: dict[str, float] = field(default_factory=dict)


def regress(
    columns: Mapping[str, FloatArray],
    target: FloatArray,
    group: NDArray[np.int64],
    nuisance: Collection[str] = (),
    shared: Sequence[NDArray[np.int64]] = (),
) -> LinearFit:
    """Least squares of ``target`` (n,) on named columns (n,), standard deviations clustered by ``group`` (n,).

    A column that is zero, or that the others make up but for 1 % of its norm, is left out and named. Columns named in
    ``nuisance`` are fitted and not reported. The covariance is the jackknife over groups: each is left out once, so
    noise may remember itself within a group as it likes, and a group with much leverage counts as what it is
    (Bell and McCaffrey 2002, "CR3"). Errors may be shared across groups as well: what those of the levels in ``shared``
    (:func:`.shared_covariance`) add is added. The degrees of freedom are Satterthwaite's. With less than four groups,
    rows are taken in 20 consecutive batches.
    """
    names, missing = _independent(columns)
    reported = [name for name in names if name not in nuisance]
    missing = [name for name in missing if name not in nuisance]
    if not reported or target.size <= len(names):
        return LinearFit({}, {}, tuple(n for n in columns if n not in nuisance), float("nan"), int(target.size))
    x = np.column_stack([columns[name] for name in names])
    scale = np.linalg.norm(x, axis=0)
    x = x / scale
    normal = x.T @ x
    inverse = np.linalg.inv(normal)
    solution = inverse @ (x.T @ target)
    residual = target - x @ solution
    std, freedom = _jackknife(x, residual, normal, inverse, group)
    recordings = Means.of_rows(x, inverse, residual, group, shared)
    if recordings is not None:
        std, freedom = _widened(std, freedom, *shared_covariance(*recordings))
    values, std = solution / scale, std / scale
    rows = {name: names.index(name) for name in reported}
    return LinearFit(
        {name: float(values[j]) for name, j in rows.items()},
        {name: float(std[j]) for name, j in rows.items()},
        tuple(missing),
        float(np.sqrt(np.mean(residual**2))),
        int(target.size),
        {name: float(freedom[j]) for name, j in rows.items()},
    )


def _widened(
    std: FloatArray, freedom: FloatArray, covariance: FloatArray, few: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Add a second, independent source of error: standard deviations and Welch's degrees of freedom (P,)."""
    more = np.diag(covariance)
    both = std**2 + more
    some = both > 0.0
    degrees = freedom.copy()
    degrees[some] = both[some] ** 2 / (std[some] ** 4 / freedom[some] + more[some] ** 2 / few[some])
    return np.sqrt(both), degrees


def _jackknife(
    x: FloatArray, residual: FloatArray, normal: FloatArray, inverse: FloatArray, group: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """Standard deviations (P,) by leaving groups out one by one, and their degrees of freedom (P,)."""
    if np.unique(group).size < FEW_GROUPS:
        group = np.arange(residual.size) * BATCHES // residual.size
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=group[order[0]] - 1))
    moves, shares = [], []
    for rows in np.split(order, starts[1:]):
        part = x[rows]
        gram = part.T @ part
        # rcond: what only this group determines cannot be left out; there its score counts as it stands
        moves.append(np.linalg.pinv(normal - gram, rcond=1e-9, hermitian=True) @ (part.T @ residual[rows]))
        shares.append(np.einsum("ij,jk,ki->i", inverse, gram, inverse))
    count = len(moves)
    move, share = np.asarray(moves), np.asarray(shares)
    std = np.sqrt((count - 1) / count * (move**2).sum(axis=0))
    effective = share.sum(axis=0) ** 2 / np.maximum((share**2).sum(axis=0), 1e-300)
    return std, np.maximum(effective - 1.0, 1.0)


def _independent(columns: Mapping[str, FloatArray]) -> tuple[list[str], list[str]]:
    """Split symbols into those whose column is no combination of all others, and the rest.

    Of columns that are alike the one that comes later is left out first, so callers list what matters most first.
    """
    names, missing = list(columns), [name for name in columns if not np.any(columns[name])]
    names = [name for name in names if name not in missing]
    while names:
        unit = np.column_stack([columns[name] / np.linalg.norm(columns[name]) for name in names])
        gram = unit.T @ unit
        inverse = np.linalg.pinv(gram, rcond=1e-12, hermitian=True)
        independent_share = np.sqrt(1.0 / np.maximum(np.diag(inverse), 1.0))
        if np.linalg.matrix_rank(gram, tol=1e-10 * len(names), hermitian=True) < len(names):
            _, vectors = np.linalg.eigh(gram)
            independent_share = np.where(np.abs(vectors[:, 0]) > 1e-3, 0.0, independent_share)
        weak = [i for i in range(len(names)) if independent_share[i] < MIN_INDEPENDENT_SHARE]
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
