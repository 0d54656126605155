"""How sure a number is where recordings differ by more than their noise.

The covariance of a fit holds the noise of rows. What differs from recording to recording, a friction that is not
the same after each start or a motion that few recordings hold, shares its error with all rows of a recording. So each
recording is asked in which direction it alone would move a number; how far apart they are says how sure it is (Liang
and Zeger, Biometrika 73 (1986) 13).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.mismatch.regression.bank import Bank, Fit
from bench.simulation.frame import FloatArray, IntArray

FEWEST = 2.0
"""recordings that count, up to which their differences say nothing: two agree by chance, and one always"""
ROUNDING = 1e-12
"""eigenvalue of a correlation below which it is rounding"""


def apart(influence: FloatArray, left: FloatArray, starts: IntArray) -> FloatArray:
    """Covariance (k, k) of some numbers by the differences of recordings.

    ``influence`` (n, k): by how much each row moves each number; ``left`` (n,): what the fit leaves of the rows, both
    whitened; ``starts`` first row of each recording, and the end.
    """
    moved = np.zeros((starts.size - 1, influence.shape[1]))
    weight = np.zeros_like(moved)
    for k, (a, b) in enumerate(itertools.pairwise(starts)):
        moved[k] = left[a:b] @ influence[a:b]
        weight[k] = np.sum(influence[a:b] ** 2, axis=0)
    # of recordings that say nearly nothing of a number none counts
    count = np.sum(weight, axis=0) ** 2 / np.maximum(np.sum(weight**2, axis=0), 1e-300)
    moved *= np.sqrt(np.where(count > FEWEST, count / np.maximum(count - 1.0, 1.0), 0.0))
    return np.asarray(moved.T @ moved)


def wider(covariance: FloatArray, seen: FloatArray) -> FloatArray:
    """A ``covariance`` (k, k) by the noise of rows, made wider in all directions in which that ``seen`` (k, k) of
    recordings is.
    """
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    root = scale[:, None] * vectors * np.sqrt(np.maximum(values, ROUNDING))
    inverse = (vectors / np.sqrt(np.maximum(values, ROUNDING))).T / scale
    along, directions = np.linalg.eigh(inverse @ seen @ inverse.T)
    half = root @ directions * np.sqrt(np.maximum(along, 1.0))
    return np.asarray(half @ half.T)


@dataclass(frozen=True, slots=True)
class Differences:
    """Covariance (k, k) of the coefficients of columns ``index`` by the differences of recordings."""

    index: tuple[int, ...]
    seen: FloatArray

    @classmethod
    def of(cls, bank: Bank, fitted: Fit) -> Differences:
        """Those of a fit; the bank still holds the columns."""
        if not fitted.index:
            return NONE
        columns = bank.less_offsets(bank.columns.some(fitted.index), fitted.variance)
        left = bank.less_offsets(bank.y, fitted.variance) - columns @ fitted.coefficients
        return cls(fitted.index, apart(columns @ fitted.covariance, left, bank.whitening.starts))

    def widened(self, columns: Sequence[int], covariance: FloatArray) -> FloatArray:
        """A covariance (k, k) of some columns with the differences of recordings; as it is where they are not known."""
        if not set(columns) <= set(self.index):
            return covariance
        at = [self.index.index(i) for i in columns]
        return wider(covariance, self.seen[np.ix_(at, at)])


NONE = Differences((), np.zeros((0, 0)))
"""where nothing is known of differences"""
