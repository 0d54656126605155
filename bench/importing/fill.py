"""Numbers that stand for a sample that is not there: 9.96921e36 of netCDF, 9.9e37 and 9.91e37 of SCPI instruments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

LEAST_FILL = 1e30
"""Size from which a number is taken for a fill value: nothing of a machine is as large, and all of these are larger."""


def filled(values: NDArray[Any]) -> NDArray[np.bool_]:
    """Samples (N,) that are fill values; inf and NaN are none."""
    if values.dtype.kind != "f":
        return np.zeros(values.shape, dtype=bool)
    with np.errstate(invalid="ignore"):
        return np.asarray((np.abs(values) >= LEAST_FILL) & np.isfinite(values))


def fill_note(name: str, indices: Sequence[int], size: int, first: str) -> str:
    """Say which samples of a channel were taken as missing; ``first`` is where the first of them stands."""
    verb = "is a fill value" if len(indices) == 1 else "are fill values"
    return (
        f"{name}: {len(indices)} of {size} samples {verb} ({LEAST_FILL:g} or more in size, such as 9.9e37) and count "
        f"as missing, the first in {first}"
    )
