"""Rows of the input's torque balance, however they were made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows (n,), SI units: speed, acceleration and torque at the motor shaft, load torque / ratio, temperature °C.

    ``group`` is the recording a row belongs to, ``direction`` the sign of the motion (filtered like the rest, so not
    always a whole number); what was not measured is NaN. ``size`` is the mean of |load torque| / ratio: where the
    torque swings about 0 within a row it is more than the size of the mean.
    """

    group: NDArray[np.int64]
    direction: FloatArray
    omega: FloatArray
    acceleration: FloatArray
    motor_torque: FloatArray
    torque: FloatArray
    temperature: FloatArray
    size: FloatArray


def join(parts: Sequence[Rows]) -> Rows:
    """Put the rows of several recordings one after the other."""
    if not parts:
        return Rows(np.empty(0, dtype=np.int64), *(np.empty(0) for _ in range(7)))
    return Rows(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Rows)))
