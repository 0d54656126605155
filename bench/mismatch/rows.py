"""Rows of one channel: what a block of samples says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bench.simulation.frame import FloatArray, Frame, IntArray, concatenate


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of one channel: frame, block means y, valid samples a block, variance of the samples inside a block.

    Where the channel is compared over the angle: ``lean``, covariance of the samples with the angle inside a block, and
    ``sweep``, variance of the angle there; empty where it is not.
    """

    frame: Frame
    y: FloatArray
    number: FloatArray
    within: FloatArray
    lean: FloatArray = field(default_factory=lambda: np.zeros(0))
    sweep: FloatArray = field(default_factory=lambda: np.zeros(0))

    def take(self, rows: NDArray[np.bool_] | IntArray) -> Rows:
        """Return the rows chosen (mask or indices)."""
        lean, sweep = (self.lean[rows], self.sweep[rows]) if self.lean.size else (self.lean, self.sweep)
        return Rows(self.frame.take(rows), self.y[rows], self.number[rows], self.within[rows], lean, sweep)


def join(parts: Sequence[Rows]) -> Rows:
    """Rows of several recordings as one."""
    return Rows(
        concatenate([p.frame for p in parts]),
        np.concatenate([p.y for p in parts]),
        np.concatenate([p.number for p in parts]),
        np.concatenate([p.within for p in parts]),
        np.concatenate([p.lean for p in parts]),
        np.concatenate([p.sweep for p in parts]),
    )
