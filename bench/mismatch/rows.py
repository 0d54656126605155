"""Rows of one channel: what a block of samples says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.simulation.frame import FloatArray, Frame, IntArray, concatenate


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of one channel: frame, block means y, valid samples a block, variance of the samples inside a block."""

    frame: Frame
    y: FloatArray
    number: FloatArray
    within: FloatArray

    def take(self, rows: NDArray[np.bool_] | IntArray) -> Rows:
        """Return the rows chosen (mask or indices)."""
        return Rows(self.frame.take(rows), self.y[rows], self.number[rows], self.within[rows])


def join(parts: Sequence[Rows]) -> Rows:
    """Rows of several recordings as one."""
    return Rows(
        concatenate([p.frame for p in parts]),
        np.concatenate([p.y for p in parts]),
        np.concatenate([p.number for p in parts]),
        np.concatenate([p.within for p in parts]),
    )
