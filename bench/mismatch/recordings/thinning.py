"""Samples that tell the same are averaged as they are read.

Rates are smoothed over a window, and every channel is compared in block means: a window of thirty samples says what one
of a hundred and twenty says, at a quarter of the work. So a recording at 2 kHz whose rates are smoothed over 60 ms is
averaged over groups of four samples before anything is derived from it. The mean over a block of such groups is the
mean over the block's samples, so no average changes; how the samples scatter inside the groups is kept beside them, for
noise and residuals are given per sample at the recording's own rate. Wild samples are found before, one by one. What
looks at single samples (the spectra of tones and of the motor's ripple) still gets them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from bench.simulation.frame import FloatArray

T = TypeVar("T", bound=np.generic)
SAMPLES_A_WINDOW = 30


def group_of(rate: float, span: float) -> int:
    """Samples averaged into one, for a sample rate in Hz and a smoothing window in s; at least 1."""
    return max(1, int(rate * span / SAMPLES_A_WINDOW + 1e-9))


@dataclass(frozen=True, slots=True)
class Thinning:
    """Averages over groups of ``group`` samples; the last samples, too few for a group, are left out."""

    group: int

    def _grouped(self, values: NDArray[T]) -> NDArray[T]:
        number = values.size // self.group
        return values[: number * self.group].reshape(number, self.group)

    def mean(self, signal: FloatArray) -> FloatArray:
        """Mean of each group."""
        return signal if self.group == 1 else _mean(self._grouped(signal))

    def first(self, values: NDArray[T]) -> NDArray[T]:
        """First value of each group."""
        return values if self.group == 1 else self._grouped(values)[:, 0]

    def every(self, values: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether something holds for all samples of a group."""
        return values if self.group == 1 else np.asarray(self._grouped(values).all(axis=1))

    def measured(self, signal: FloatArray, valid: NDArray[np.bool_]) -> Measured:
        """A channel in groups: only valid samples count."""
        if self.group == 1:
            return Measured(signal, valid.astype(np.float64), np.zeros(signal.size), signal, valid)
        samples = np.asarray(self._grouped(signal), dtype=np.float64)
        good = np.asarray(self._grouped(valid), dtype=bool)
        if good.all():
            mean = _mean(samples)
            number = np.full(mean.size, float(self.group))
        else:
            number = good.sum(axis=1).astype(np.float64)
            total = np.where(good, samples, 0.0).sum(axis=1)
            mean = np.where(number > 0, total / np.maximum(number, 1.0), _mean(samples))
        apart = np.where(good, samples - mean[:, None], 0.0)
        return Measured(mean, number, np.einsum("ij,ij->i", apart, apart), signal, valid)

    def inner(self, one: FloatArray, other: FloatArray, valid: NDArray[np.bool_]) -> FloatArray:
        """Sum of products of two signals' deviations from their means inside each group, over its valid samples."""
        if self.group == 1:
            return np.zeros(one.size)
        good = np.asarray(self._grouped(valid), dtype=np.float64)
        number = np.maximum(good.sum(axis=1), 1.0)
        a, b = (np.asarray(self._grouped(values), dtype=np.float64) for values in (one, other))
        a, b = (x - (np.einsum("ij,ij->i", x, good) / number)[:, None] for x in (a, b))
        return np.asarray(np.einsum("ij,ij,ij->i", a, b, good))

    def spread(self, values: NDArray[T], size: int) -> NDArray[T]:
        """Values of the groups for each of ``size`` samples; the last of them for the samples left out."""
        if self.group == 1:
            return values
        out = np.repeat(values, self.group)
        return np.append(out, np.full(size - out.size, values[-1])) if out.size < size else out


def _mean(groups: FloatArray) -> FloatArray:
    # (n, 4).mean(axis=1) takes five times as long: numpy adds up four numbers at a time
    return np.asarray(np.einsum("ij->i", groups) / groups.shape[1])


@dataclass(frozen=True, slots=True)
class Measured:
    """A compared channel: ``mean`` and ``number`` of the valid samples in each group, the sum of squares of their
    deviations inside it (``scatter``), and the ``samples`` themselves with what is ``valid`` of them.
    """

    mean: FloatArray
    number: FloatArray
    scatter: FloatArray
    samples: FloatArray
    valid: NDArray[np.bool_]

    def less(self, values: FloatArray | None, thinning: Thinning) -> Measured:
        """The channel less values of the groups."""
        if values is None:
            return self
        return replace(self, mean=self.mean - values, samples=self.samples - thinning.spread(values, self.samples.size))

    def without(self, groups: NDArray[np.bool_] | None) -> Measured:
        """The channel with the groups marked counting as not valid."""
        if groups is None:
            return self
        return replace(self, number=np.where(groups, 0.0, self.number), scatter=np.where(groups, 0.0, self.scatter))

    def cut(self, rows: slice, group: int) -> Measured:
        """The groups ``rows`` and their samples."""
        inside = slice(rows.start * group, rows.stop * group)
        return Measured(
            self.mean[rows], self.number[rows], self.scatter[rows], self.samples[inside], self.valid[inside]
        )
