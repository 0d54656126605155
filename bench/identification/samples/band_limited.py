"""Rows of the input's torque balance by band-limited differentiation, for recordings from elsewhere.

A position sampled fast is low-passed without phase shift (Butterworth, forward and backward) and differentiated by
central differences; then torque and every regressor, the sign of the speed among them, pass the same decimating filter,
so that it cancels. The usual way of inverse dynamic identification (A. Janot, M. Gautier, M. Brunot, "Data Set and
Reference Models of EMPS", 2019).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from bench.identification.samples.rows import Rows

FloatArray = NDArray[np.float64]

FILTER_ORDER = 4
EDGE_ROWS = 5
"""Decimated rows dropped at each end, where the filters have not settled."""


def _low_pass(x: FloatArray, rate: float, limit_hz: float) -> FloatArray:
    sections = butter(FILTER_ORDER, limit_hz, fs=rate, output="sos")
    return np.asarray(sosfiltfilt(sections, x))


def band_limited_rows(
    channels: dict[str, FloatArray], sample_rate: float, ratio: float, group: int, limit_hz: float | None = None
) -> Rows | None:
    """Rows of one recording, decimated to about twice ``limit_hz`` (a tenth of the sample rate unless given).

    ``channels`` (N,) in SI units; None without motor_angle and motor_torque or with too few samples. Standstill counts
    as motion with the sign of what little there is, as in the published identification.
    """
    if "motor_angle" not in channels or "motor_torque" not in channels:
        return None
    limit = limit_hz or 0.1 * sample_rate
    factor = max(1, int(sample_rate / limit))
    if channels["motor_angle"].size < 10 * EDGE_ROWS * factor:
        return None
    step = 1.0 / sample_rate
    angle = _low_pass(channels["motor_angle"], sample_rate, limit)
    omega = np.gradient(angle, step)
    keep = slice(EDGE_ROWS, -EDGE_ROWS)

    def reduced(x: FloatArray) -> FloatArray:
        # A Butterworth filter leaves constants exactly as they are, which Chebyshev's decimators do not.
        return (_low_pass(x, sample_rate, 0.4 * sample_rate / factor) if factor > 1 else x)[::factor][keep]

    def optional(name: str) -> FloatArray:
        return reduced(channels[name]) if name in channels else np.full(rows.size, np.nan)

    rows = reduced(omega)
    torque = optional("load_torque") / ratio
    return Rows(
        np.full(rows.size, group, dtype=np.int64),
        reduced(np.sign(omega)),
        rows,
        reduced(np.gradient(omega, step)),
        reduced(channels["motor_torque"]),
        torque,
        optional("temperature"),
        np.abs(torque),
    )
