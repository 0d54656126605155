"""How sure a number is where recordings differ by more than their noise.

The covariance of a fit holds the noise of rows. What differs from recording to recording, a friction that is not
the same after each start or a motion that few recordings hold, shares its error with all rows of a recording. So each
recording is asked in which direction it alone would move a number; how far apart they are says how sure it is (Liang
and Zeger, Biometrika 73 (1986) 13).
"""

from __future__ import annotations

import numpy as np

from bench.mismatch.regression.bank import Bank, Fit
from bench.simulation.frame import FloatArray, IntArray

FEWEST = 2.0
"""recordings that count, up to which their differences say nothing: two agree by chance, and one always"""


def wider(influence: FloatArray, left: FloatArray, starts: IntArray, variance: FloatArray) -> FloatArray:
    """Factors (k,), at least 1, by which standard deviations grow with the differences of recordings.

    ``influence`` (n, k): by how much each row moves each number; ``left`` (n,): what the fit leaves of the rows, both
    whitened; ``starts`` first row of each recording, and the end; ``variance`` (k,) by the noise of rows.
    """
    first = starts[:-1][np.diff(starts) > 0]
    moved = np.add.reduceat(influence * left[:, None], first, axis=0)
    weight = np.add.reduceat(influence**2, first, axis=0)
    # of recordings that say nearly nothing of a number none counts
    count = np.sum(weight, axis=0) ** 2 / np.maximum(np.sum(weight**2, axis=0), 1e-300)
    seen = np.sum(moved**2, axis=0) * np.where(count > FEWEST, count / np.maximum(count - 1.0, 1.0), 0.0)
    return np.asarray(np.sqrt(np.maximum(1.0, seen / np.maximum(variance, 1e-300))))


def of_fit(bank: Bank, fitted: Fit) -> dict[int, float]:
    """These factors of a fit's coefficients, by the numbers of their columns; the bank still holds the columns."""
    index = list(fitted.index)
    if not index:
        return {}
    columns = bank.less_offsets(bank.columns.some(index), fitted.variance)
    left = bank.less_offsets(bank.y, fitted.variance) - columns @ fitted.coefficients
    factors = wider(columns @ fitted.covariance, left, bank.whitening.starts, np.diag(fitted.covariance))
    return dict(zip(index, factors.tolist(), strict=True))
