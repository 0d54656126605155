"""Columns that are kept: those of a whole bank are many megabytes, and more come with each form that is refined."""

from __future__ import annotations

import itertools
from bisect import bisect_right
from collections.abc import Iterator, Sequence

import numpy as np

from bench.simulation.frame import FloatArray

AT_ONCE = 512
"""columns for which memory is set aside at once; what is not written to takes none"""


class Kept:
    """Columns of ``rows`` rows each in few large pieces: further ones are written behind the last, none is moved."""

    def __init__(self, rows: int) -> None:
        self.rows = rows
        self.size = 0
        self._pieces: list[FloatArray] = []
        self._begins: list[int] = []

    def add(self, columns: FloatArray) -> None:
        """Keep columns (n, k); those of one call stand side by side in one piece."""
        number = columns.shape[1]
        here = self.size - self._begins[-1] if self._begins else 0
        if not self._pieces or here + number > self._pieces[-1].shape[1]:
            self._pieces.append(np.empty((self.rows, max(AT_ONCE, number)), order="F"))
            self._begins.append(self.size)
            here = 0
        self._pieces[-1][:, here : here + number] = columns
        self.size += number

    def clear(self) -> None:
        """Let go of the columns; their numbers stay taken."""
        self._pieces.clear()
        self._begins.clear()

    def pieces(self, first: int = 0) -> Iterator[tuple[slice, FloatArray]]:
        """Numbers of the columns in each piece, and the columns (n, k); from column ``first`` on."""
        for begin, end, piece in zip(self._begins, [*self._begins[1:], self.size], self._pieces, strict=True):
            if end > first:
                yield slice(max(begin, first), end), piece[:, max(first - begin, 0) : end - begin]

    def column(self, number: int) -> FloatArray:
        """One column (n,)."""
        piece = bisect_right(self._begins, number) - 1
        return self._pieces[piece][:, number - self._begins[piece]]

    def some(self, index: Sequence[int]) -> FloatArray:
        """A copy of some columns (n, k)."""
        out = np.empty((self.rows, len(index)), order="F")
        for k, number in enumerate(index):
            out[:, k] = self.column(number)
        return out

    def products(self, values: FloatArray, first: int = 0) -> FloatArray:
        """Products of the columns from ``first`` on with values (n,) or (n, m): (p,) or (p, m)."""
        out = np.empty((self.size - first, *values.shape[1:]))
        for rows, piece in self.pieces(first):
            out[rows.start - first : rows.stop - first] = piece.T @ values
        return out

    def products_by(self, values: FloatArray, starts: Sequence[int], first: int = 0) -> FloatArray:
        """Products of the columns from ``first`` on with values (n,) over each part of the rows (parts, p), from one of
        ``starts`` (parts + 1,) to the next.
        """
        out = np.empty((len(starts) - 1, self.size - first))
        for rows, piece in self.pieces(first):
            target = slice(rows.start - first, rows.stop - first)
            for part, (a, b) in enumerate(itertools.pairwise(starts)):
                out[part, target] = values[a:b] @ piece[a:b]
        return out
