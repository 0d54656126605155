"""What the times of a recording's samples have to be."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def not_increasing(time: NDArray[np.float64]) -> str | None:
    """Where the times (n,) in s of a recording do not strictly increase, in words; None where they do."""
    steps = np.diff(time)
    if np.all(steps > 0):
        return None
    index = int(np.argmin(steps > 0)) + 1
    return f"at index {index} is {time[index]:.9g} s after {time[index - 1]:.9g} s, it should strictly increase"
