"""The offset of the transmission error as a function of the instant's torque, speed and temperature.

Within a revolution torque and speed waver a little; the offset follows. Its part about the recording's mean is taken
off before the order spectrum is made, so that a wavering load is not read as a harmonic order.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch.spectrum import Turn
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.nominal.transmission_error import OFFSET

RIDGE = 1e-5
ROWS_AT_ONCE = 1 << 15
_FORM = OFFSET.forms["transmission_error"][0]


def fit_offset(frame: Frame, y: FloatArray, turns: Sequence[Turn], train: set[int]) -> FloatArray:
    """Coefficients (20,) of the offset's polynomial, from block means of the steady revolutions of the recordings
    ``train``.
    """
    blocks: list[FloatArray] = []
    means: list[float] = []
    for turn in turns:
        if turn.recording not in train:
            continue
        columns = _FORM.columns(frame.take(turn.rows), ())
        blocks.append(columns.mean(axis=0))
        means.append(float(np.mean(y[turn.rows])))
    if not blocks:
        return np.zeros(20)
    x = np.array(blocks)
    scale = np.maximum(np.sqrt(np.mean(x**2, axis=0)), 1e-9)
    normal = (x / scale).T @ (x / scale) / len(blocks) + RIDGE * np.eye(x.shape[1])
    return np.asarray(np.linalg.solve(normal, (x / scale).T @ np.array(means) / len(blocks)) / scale)


def wavering(frame: Frame, coefficients: FloatArray) -> FloatArray:
    """The offset at each row less the recording's mean offset."""
    offset = np.concatenate(
        [
            _FORM.columns(frame.take(slice(a, a + ROWS_AT_ONCE)), ()) @ coefficients
            for a in range(0, frame.size, ROWS_AT_ONCE)
        ]
    )
    out = np.zeros(frame.size)
    edges = np.flatnonzero(np.diff(frame.recording)) + 1
    for part in np.split(np.arange(frame.size), edges):
        steady = frame.steady[part] > 0.5
        out[part] = offset[part] - (offset[part][steady].mean() if steady.any() else 0.0)
    return out
