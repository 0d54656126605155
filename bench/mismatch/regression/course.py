"""What regressors add on the rows of a frame, a group of recordings at a time.

A channel compared over the angle has some hundred thousand rows; all columns of a model there at once would be the
largest arrays of a whole analysis.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from bench.mismatch.regression.excess import Normal
from bench.mismatch.regression.regressors import Regressor, remembers
from bench.simulation.frame import FloatArray, Frame, IntArray, recording_starts

ROWS_AT_ONCE = 1 << 13


def groups(frame: Frame) -> list[slice]:
    """Rows of whole recordings, about as many as are taken at once."""
    ends = recording_starts(frame)[1:]
    out: list[slice] = []
    begin = 0
    for end, following in zip(ends, [*ends[1:], np.inf], strict=True):
        if following - begin > ROWS_AT_ONCE:
            out.append(slice(begin, int(end)))
            begin = int(end)
    return out


def by_group(regressors: Sequence[Regressor], frame: Frame) -> Iterator[tuple[slice, list[FloatArray]]]:
    """Columns (rows, k) of some regressors on each group of recordings; on all rows where a state goes on from one
    recording to the next.
    """
    if any(remembers(r) for r in regressors) or frame.size <= ROWS_AT_ONCE:
        yield slice(0, frame.size), [r.columns(frame) for r in regressors]
        return
    for rows in groups(frame):
        part = frame.take(rows)
        yield rows, [r.columns(part) for r in regressors]


def added(regressor: Regressor, frame: Frame, coefficients: FloatArray) -> FloatArray:
    """What a regressor adds at the rows of a frame: (n,), or (n, m) for m sets of ``coefficients`` (k, m)."""
    out = np.zeros((frame.size, *coefficients.shape[1:]))
    for rows, (columns,) in by_group([regressor], frame):
        out[rows] = columns @ coefficients
    return out


def columns_at(regressor: Regressor, frame: Frame, chosen: IntArray) -> FloatArray:
    """Columns of a regressor at ``chosen`` rows of a frame, ascending (rows, k)."""
    parts = []
    for rows, (columns,) in by_group([regressor], frame):
        first, last = np.searchsorted(chosen, [rows.start, rows.stop])
        parts.append(columns[chosen[first:last] - rows.start])
    return np.vstack(parts)


def best_coefficients(
    values: FloatArray, regressors: Sequence[Regressor], frame: Frame, number: FloatArray
) -> FloatArray:
    """Coefficients (k,) with which ``regressors`` say the most of ``values`` (n,), rows of ``number`` (n,) samples."""
    if not regressors:
        return np.zeros(0)
    normal = Normal()
    for rows, columns in by_group(regressors, frame):
        normal.add(columns, values[rows], number[rows])
    return normal.coefficients()


def beyond(values: FloatArray, regressors: Sequence[Regressor], frame: Frame, number: FloatArray) -> FloatArray:
    """Part of ``values`` (n,) that ``regressors`` do not say; see :func:`bench.mismatch.regression.excess.excess`."""
    return less(values, regressors, frame, best_coefficients(values, regressors, frame, number))


def less(values: FloatArray, regressors: Sequence[Regressor], frame: Frame, coefficients: FloatArray) -> FloatArray:
    """``values`` (n,) less what ``regressors`` say with ``coefficients`` (k,)."""
    out = values.copy()
    for rows, columns in by_group(regressors, frame) if regressors else ():
        out[rows] -= np.hstack(columns) @ coefficients
    return out
