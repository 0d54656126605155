"""The transmission error of the current load-side revolution, bin by bin as the shaft turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BINS = 2048
"""Angle bins of a revolution; orders up to 1024."""
HIGHEST_ORDER = 320
_CURVE = 512


@dataclass(frozen=True, slots=True)
class Spectrum:
    """One revolution: amplitude in rad at the orders 1 … HIGHEST_ORDER, the curve without mean in rad, shape (512,)."""

    amplitude: FloatArray
    curve: FloatArray
    rms: float


class Revolution:
    """Keeps, for each angle bin, the mean transmission error of the last pass.

    A bin that is entered anew forgets its earlier pass, so that the curve is always the last full revolution whatever
    the direction; after a reversal the bins are passed again and replaced.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget everything: a new motion begins."""
        self._sum, self._count = np.zeros(BINS), np.zeros(BINS, np.int64)
        self._last = -1

    @property
    def share(self) -> float:
        """Share of the revolution that has been seen, 0 … 1."""
        return 1.0 if self.is_whole else float(np.count_nonzero(self._count)) / BINS

    def add(self, theta: FloatArray, error: FloatArray) -> None:
        """Take input angles θ = motor angle / u and errors q − θ, both rad, shape (n,), in their order."""
        if theta.size == 0:
            return
        index = np.minimum((np.mod(theta, 2.0 * np.pi) * (BINS / (2.0 * np.pi))).astype(np.int64), BINS - 1)
        # of many revolutions at once only the last counts
        begin = int(np.searchsorted(-np.abs(theta - theta[-1]), -2.0 * np.pi, side="right")) if theta.size > 1 else 0
        index, error = index[begin:], error[begin:]
        count = np.bincount(index, minlength=BINS)
        sums = np.bincount(index, weights=error, minlength=BINS)
        entered = count > 0
        if self._last >= 0:
            # the bin in which the last block ended is still being passed
            entered[self._last] = False
        self._sum[entered], self._count[entered] = 0.0, 0
        self._sum += sums
        self._count += count
        self._last = int(index[-1])

    def spectrum(self) -> Spectrum | None:
        """Return the spectrum once a whole revolution has been seen; bins a fast motion jumps over are interpolated."""
        if not self.is_whole:
            return None
        seen = self._count > 0
        mean = self._sum / np.maximum(self._count, 1)
        if not seen.all():
            mean[~seen] = np.interp(np.flatnonzero(~seen), np.flatnonzero(seen), mean[seen], period=BINS)
        mean -= mean.mean()
        amplitude = np.abs(np.fft.rfft(mean))[1 : HIGHEST_ORDER + 1] * (2.0 / BINS)
        return Spectrum(amplitude, mean.reshape(_CURVE, -1).mean(axis=1), float(np.sqrt(np.mean(mean**2))))

    @property
    def is_whole(self) -> bool:
        """Whether a whole revolution has been seen, but for bins a fast motion jumps over."""
        seen = np.flatnonzero(self._count > 0)
        if seen.size < BINS // 4:
            return False
        gaps = np.diff(np.append(seen, seen[0] + BINS))
        return int(gaps.max()) <= 8
