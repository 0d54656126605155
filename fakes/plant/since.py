"""What terms ask of the way that a bench has come: since when it moves as it does; and heat that adds up.

Compiled, and carried in an array from block to block: nothing depends on how cycles are cut into blocks.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def follow(direction: Floats, travel: Floats, time: Floats, memory: Floats, out: Floats) -> None:
    """Fill ``out`` (3, n): travel and time since the motion last began, and 1 where it went the other way before.

    ``memory`` (5,): direction in the cycle before, direction of the last motion (0: there was none), travel and time
    where this motion began, whether the one before went the other way.
    """
    for i in range(direction.size):
        now = direction[i]
        if now != 0.0 and now != memory[0]:
            memory[4] = 1.0 if now * memory[1] < 0.0 else 0.0
            memory[1], memory[2], memory[3] = now, travel[i], time[i]
        memory[0] = now
        out[0, i] = travel[i] - memory[2]
        out[1, i] = time[i] - memory[3]
        out[2, i] = memory[4]


@njit(cache=True, error_model="numpy")
def thermometer_change(
    rate: Floats, first: int, interval: int, cooling: float, step: float, memory: Floats, out: Floats
) -> None:
    """Fill ``out`` (n,) with the K by which a thermometer that is read every ``interval`` cycles shows more.

    ``rate`` (n,) K/s beyond the plant's own balance, of cycles from ``first`` on; ``cooling`` 1/s, in which the
    difference is forgotten. ``memory`` (2,): the difference, and what of it was last read.
    """
    for i in range(rate.size):
        memory[0] += step * (rate[i] - cooling * memory[0])
        if (first + i) % interval == 0:
            memory[1] = memory[0]
        out[i] = memory[1]
