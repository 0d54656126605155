"""Products of whitened columns within each fold, made when they are asked for and kept where they will be again.

A Gram matrix of all columns of a bank a fold is the largest thing one could compute: thousands of columns, hundreds of
folds, and nearly all of it products of two candidates that never stand in one model. Needed are the products of every
candidate with itself, and with the columns that many models share (the simulation's, and the terms chosen so far).
Those columns are recognised by being asked for again and again, and get their products with all others.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from bench.simulation.frame import FloatArray, IntArray

_SHARED = 3
"""sets in which a column is met before its products with all columns are made"""


class Products:
    """Products a fold of columns (n, p), the measured y (n,) and the column of ones (n,), all whitened.

    ``starts`` (recordings + 1,) row ranges; ``folds`` (recordings,) fold of each recording, numbered without gaps.
    Column p is y.
    """

    def __init__(self, columns: FloatArray, y: FloatArray, one: FloatArray, starts: IntArray, folds: IntArray) -> None:
        self._columns, self._y, self._one, self._starts = columns, y, one, starts
        self._folds = folds
        self._order = np.argsort(folds, kind="stable")
        self._first = np.searchsorted(folds[self._order], np.arange(int(folds.max()) + 1))
        p = columns.shape[1]
        self._ones = np.empty((folds.size, p + 1))
        for r, (a, b) in enumerate(itertools.pairwise(starts)):
            self._ones[r, :p] = one[a:b] @ columns[a:b]
            self._ones[r, p] = one[a:b] @ y[a:b]
        self._energy = np.add.reduceat(one**2, starts[:-1])
        self._place = np.full(p + 1, -1, dtype=np.int64)
        self._rows = np.zeros((self._first.size, 0, p + 1))
        self._own: dict[tuple[int, ...], FloatArray] = {}
        self._met: dict[int, int] = {}
        self._beside: tuple[tuple[int, ...], FloatArray] | None = None
        """the columns that many models share, as they stand beside those that are replaced again and again"""
        self._anchor([p])

    def parted(self, chosen: Sequence[int]) -> tuple[list[int], list[int]]:
        """The columns of a model that many models share, and those of its own."""
        self._look([i for i in chosen if self._place[i] < 0])
        shared = [i for i in chosen if self._place[i] >= 0]
        return shared, [i for i in chosen if self._place[i] < 0]

    def cost(self, variance: float) -> FloatArray:
        """Logarithm of the determinant of the offsets' covariance, a fold."""
        if variance == 0.0 or np.isinf(variance):
            return np.zeros(self._first.size)
        return self._by_fold(np.log1p(variance * self._energy))

    def marginal(self, left: Sequence[int], right: Sequence[int], variance: float) -> FloatArray:
        """Products of the columns ``left`` and ``right`` a fold, offsets of a variance marginalised (inf: free)."""
        out = self._raw(list(left), list(right))
        if variance == 0.0 or out.size == 0:
            return out
        factor = self._shrunk(variance)
        a, b = self._ones[:, left], self._ones[:, right]
        if self._first.size == 1:
            return np.asarray(out - ((factor[:, None] * a).T @ b)[None])
        return np.asarray(out - self._by_fold((factor[:, None] * a)[:, :, None] * b[:, None, :]))

    def beside(self, new: FloatArray, index: Sequence[int], variance: float) -> tuple[FloatArray, FloatArray]:
        """Products of ``new`` columns (n, k), whitened, with each other and with the columns ``index``; all folds."""
        own = np.array([self._one[a:b] @ new[a:b] for a, b in itertools.pairwise(self._starts)])
        factor = self._shrunk(variance)[:, None]
        gram = new.T @ new - (factor * own).T @ own
        cross = self._values(list(index)).T @ new - (factor * self._ones[:, index]).T @ own
        return np.asarray(gram), np.asarray(cross)

    def _shrunk(self, variance: float) -> FloatArray:
        """What of each recording's mean its offset takes, over its energy."""
        if np.isinf(variance):
            return np.asarray(np.where(self._energy > 0, 1.0 / np.maximum(self._energy, 1e-300), 0.0))
        return np.asarray(variance / (1.0 + variance * self._energy))

    def _by_fold(self, values: FloatArray) -> FloatArray:
        if self._first.size == self._order.size:
            return np.asarray(values[self._order])
        return np.asarray(np.add.reduceat(values[self._order], self._first, axis=0))

    def _raw(self, left: list[int], right: list[int]) -> FloatArray:
        a, b = self._place[left], self._place[right]
        if np.all(a >= 0):
            return self._rows[:, a[:, None], np.asarray(right, dtype=np.int64)[None, :]]
        if np.all(b >= 0):
            return np.swapaxes(self._rows[:, b[:, None], np.asarray(left, dtype=np.int64)[None, :]], 1, 2)
        out = np.empty((self._first.size, len(left), len(right)))
        rows, columns = np.flatnonzero(a >= 0), np.flatnonzero(b >= 0)
        bare_rows, bare_columns = np.flatnonzero(a < 0), np.flatnonzero(b < 0)
        out[:, rows] = self._rows[:, a[rows][:, None], np.asarray(right, dtype=np.int64)[None, :]]
        turned = self._rows[:, b[columns][:, None], np.asarray(left, dtype=np.int64)[None, :]]
        out[:, :, columns] = np.swapaxes(turned, 1, 2)
        bare = tuple(sorted({*(left[i] for i in bare_rows), *(right[i] for i in bare_columns)}))
        own, place = self._block(bare), {column: k for k, column in enumerate(bare)}
        i = np.array([place[left[k]] for k in bare_rows], dtype=np.int64)
        j = np.array([place[right[k]] for k in bare_columns], dtype=np.int64)
        out[:, bare_rows[:, None], bare_columns[None, :]] = own[:, i[:, None], j[None, :]]
        return out

    def _block(self, bare: tuple[int, ...]) -> FloatArray:
        """Products of columns that few models share among themselves (folds, k, k)."""
        if bare not in self._own:
            own = np.zeros((self._first.size, len(bare), len(bare)))
            part = np.ascontiguousarray(self._columns[:, list(bare)])
            for r, (a, b) in enumerate(itertools.pairwise(self._starts)):
                own[self._folds[r]] += part[a:b].T @ part[a:b]
            self._own[bare] = own
        return self._own[bare]

    def _look(self, bare: list[int]) -> None:
        """Take note of a set of columns; those met in several sets are given their products with all columns."""
        if not bare or tuple(sorted(bare)) in self._own:
            return
        for i in bare:
            self._met[i] = self._met.get(i, 0) + 1
        common = [i for i in bare if self._met[i] >= _SHARED]
        if common:
            self._anchor(common)

    def _anchor(self, index: list[int]) -> None:
        p = self._columns.shape[1]
        rows = np.zeros((self._first.size, len(index), p + 1))
        own = self._values(index)
        for r, (a, b) in enumerate(itertools.pairwise(self._starts)):
            rows[self._folds[r], :, :p] += own[a:b].T @ self._columns[a:b]
            rows[self._folds[r], :, p] += self._y[a:b] @ own[a:b]
        self._place[index] = self._rows.shape[1] + np.arange(len(index))
        self._rows = np.concatenate([self._rows, rows], axis=1)
        gone = set(index)
        self._own = {bare: block for bare, block in self._own.items() if not gone & set(bare)}
        self._beside = None

    def _values(self, index: list[int]) -> FloatArray:
        p = self._columns.shape[1]
        return np.column_stack([self._y if i == p else self._columns[:, i] for i in index])

    def replace(self, index: Sequence[int], columns: FloatArray) -> None:
        """Put other columns (whitened) in the place of some."""
        place, p = list(index), self._columns.shape[1]
        self._columns[:, place] = columns
        gone = set(place)
        if self._beside is not None and gone & set(self._beside[0]):
            self._beside = None
        self._own = {bare: block for bare, block in self._own.items() if not gone & set(bare)}
        kept = [int(i) for i in np.flatnonzero(self._place >= 0) if i not in gone]
        kept.sort(key=lambda i: self._place[i])
        self._rows = self._rows[:, self._place[kept]] if len(kept) < self._rows.shape[1] else self._rows
        self._place[:] = -1
        self._place[kept] = np.arange(len(kept))
        if self._beside is None or self._beside[0] != tuple(kept):
            self._beside = tuple(kept), self._values(kept)
        anchored = self._beside[1]
        self._rows[:, :, place] = 0.0
        for r, (a, b) in enumerate(itertools.pairwise(self._starts)):
            self._rows[self._folds[r]][:, place] += anchored[a:b].T @ columns[a:b]
            self._ones[r, place] = self._one[a:b] @ columns[a:b]
        assert self._place[p] >= 0

    def close(self) -> None:
        """Let go of the columns: what is left are their products."""
        self._columns = np.zeros((0, self._columns.shape[1]))
        self._y = self._one = np.zeros(0)
        self._beside = None

    def narrowed(self, index: Sequence[int]) -> Products:
        """The products of some columns only, all of them made, with columns of their own that can be replaced."""
        out = object.__new__(Products)
        place = list(index)
        keep = [*place, self._columns.shape[1]]
        out._columns = np.asfortranarray(self._columns[:, place])
        out._y, out._one, out._starts, out._folds = self._y, self._one, self._starts, self._folds
        out._order, out._first, out._energy = self._order, self._first, self._energy
        out._ones = self._ones[:, keep]
        out._rows = np.ascontiguousarray(self._raw(keep, keep))
        out._place = np.arange(len(keep))
        out._own, out._met, out._beside = {}, {}, None
        return out
