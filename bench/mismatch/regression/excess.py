"""The excess of an effect: what of it no calibration of the simulation can say.

A place is where this lies. The simulation is refitted to the effect's own course by least squares in which every sample
counts alike, over all recordings that are compared: what the excess is then depends on the effect and on the points
that were run, not on how noise was weighted in the search.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from bench.mismatch.regression.bank import RIDGE
from bench.simulation.frame import FloatArray, Frame, recording_starts


def excess(values: FloatArray, columns: Sequence[FloatArray], number: FloatArray) -> FloatArray:
    """Part of ``values`` (n,) that ``columns`` (n, k each) do not say, rows of ``number`` (n,) samples each.

    Rows of no samples fit nothing; what is left there is given all the same.
    """
    if not columns:
        return values
    normal = Normal()
    normal.add(columns, values, number)
    return np.asarray(values - np.hstack(columns) @ normal.coefficients())


class Normal:
    """Normal equations of least squares, added up over groups of rows."""

    def __init__(self) -> None:
        self._sums: tuple[FloatArray, FloatArray] | None = None

    def add(self, columns: Sequence[FloatArray], values: FloatArray, number: FloatArray) -> None:
        """Add rows: their ``columns`` (n, k each), what is to be said (n,), how many samples each row has."""
        x = np.hstack(columns)
        weighted = x * number[:, None]
        gram, right = x.T @ weighted, weighted.T @ values
        if self._sums is not None:
            gram, right = gram + self._sums[0], right + self._sums[1]
        self._sums = gram, right

    def coefficients(self) -> FloatArray:
        """The best coefficients; 0 of columns that are nowhere."""
        assert self._sums is not None
        gram, right = self._sums
        scale = np.sqrt(np.maximum(np.diag(gram), 0.0))
        present = np.flatnonzero(scale > 0.0)
        unit = scale[present]
        normal = gram[np.ix_(present, present)] / np.outer(unit, unit) + RIDGE * np.eye(present.size)
        out = np.zeros(scale.size)
        out[present] = np.linalg.solve(normal, right[present] / unit) / unit
        return out


def levelled(values: FloatArray, frame: Frame, number: FloatArray) -> FloatArray:
    """``values`` (n, ...) less their mean over each recording, where a recording begins at a level of its own."""
    starts = recording_starts(frame)
    out = np.array(values, dtype=np.float64)
    for a, b in itertools.pairwise(starts):
        total = float(number[a:b].sum())
        if total > 0.0:
            out[a:b] -= np.tensordot(number[a:b], out[a:b], axes=(0, 0)) / total
    return out
