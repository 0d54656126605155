"""Which rows of a recording's blocks move, and which accelerate enough to say something of an inertia."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bench.identification.samples.blocks import Blocks

FloatArray = NDArray[np.float64]

MIN_ACCELERATED_ROWS = 12
SPEED_LEVEL = 0.01
"""Speeds within this share count as one level."""
TORQUE_LEVEL = 0.02
"""Torques within this share of their range count as one level."""


def moving(blocks: Blocks) -> NDArray[np.bool_]:
    """Rows in motion from end to end; at standstill friction is whatever holds the shaft.

    A row spans two blocks. That it moves on average says that motion began before its end, so only the second row
    after it is in motion throughout; the same holds before a stop.
    """
    d = blocks.direction
    same = np.zeros(d.size, dtype=bool)
    if d.size > 4:
        same[2:-2] = d[2:-2] != 0
        for off in (-2, -1, 1, 2):
            same[2:-2] &= d[2 + off : d.size - 2 + off] == d[2:-2]
    return np.asarray(same & (blocks.whole > 0))


def accelerating(acceleration: FloatArray, steady: FloatArray) -> FloatArray:
    """Acceleration (n,) where it stands out of the encoder's noise, elsewhere 0; 0 throughout where too few rows do.

    Noise in a regressor would draw its coefficient towards 0.
    """
    fast = (steady == 0) & np.isfinite(acceleration)
    noise = float(np.median(np.abs(acceleration[steady > 0]))) if (steady > 0).any() else 0.0
    out = np.where(fast & (np.abs(acceleration) > 10.0 * noise), acceleration, 0.0)
    return out if np.count_nonzero(out) >= MIN_ACCELERATED_ROWS else np.zeros_like(out)


def set_speed(speed: FloatArray, steady: FloatArray) -> FloatArray:
    """Speed (n,) of one recording's rows in order, each stretch of ``steady`` rows at its own mean.

    What a speed does within such a stretch it does because the torque swings: a regressor that answers to the error of
    its own equation would be biased, the set speed is not.
    """
    stretch = np.cumsum(np.diff(steady, prepend=steady[:1]) != 0)
    mean = np.bincount(stretch, weights=speed) / np.bincount(stretch)
    return np.where(steady > 0, mean[stretch], speed)


def levels(
    values: FloatArray, direction: FloatArray, group: NDArray[np.int64], use: NDArray[np.bool_], gap: float
) -> NDArray[np.int64]:
    """Number of the level each row (n,) belongs to: recordings whose mean of ``values`` differs by less than ``gap``.

    An encoder's counting and the rounding of a reported torque are the same in every recording of a speed, or of a
    torque, that goes the same way: they do not average out over recordings. Rows outside ``use`` (n,), and recordings
    without any, belong to no level and are −1.
    """
    names, index = np.unique(group, return_inverse=True)
    count = np.bincount(index[use], minlength=names.size)
    mean = np.bincount(index[use], weights=values[use], minlength=names.size) / np.maximum(count, 1)
    order = np.argsort(mean)
    number = np.empty(names.size, dtype=np.int64)
    number[order] = np.cumsum(np.diff(mean[order], prepend=mean[order[0]]) > gap)
    shared = 2 * number[index] + (direction > 0)
    return np.where(use & (count[index] > 0), shared, -1)
