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

    Rows of no samples fit nothing; what is left there is told all the same.
    """
    if not columns:
        return values
    x = np.hstack(columns)
    scale = np.sqrt(np.sum(x**2 * number[:, None], axis=0))
    x = x[:, scale > 0.0] / scale[scale > 0.0]
    if x.shape[1] == 0:
        return values
    weighted = x * number[:, None]
    normal = x.T @ weighted
    normal[np.diag_indices_from(normal)] += RIDGE
    return np.asarray(values - x @ np.linalg.solve(normal, weighted.T @ values))


def levelled(values: FloatArray, frame: Frame, number: FloatArray) -> FloatArray:
    """``values`` (n, ...) less their mean over each recording, where a recording begins at a level of its own."""
    starts = recording_starts(frame)
    out = np.array(values, dtype=np.float64)
    for a, b in itertools.pairwise(starts):
        total = float(number[a:b].sum())
        if total > 0.0:
            out[a:b] -= np.tensordot(number[a:b], out[a:b], axes=(0, 0)) / total
    return out
