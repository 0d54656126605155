"""What of an effect in the offset no calibration of the simulation can say, its orders among that.

Over whole revolutions at one state an order says nothing of the offset. Where the speed or the torque changes within a
revolution it does: calibrated anew, the orders take a part of what happens there, and leave waves elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch.orders.series import Scaling
from bench.mismatch.regression.course import columns_at
from bench.mismatch.regression.excess import Normal
from bench.mismatch.regression.regressors import Regressor, remembers
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.waves import ROWS_AT_ONCE

MOST_ROWS = 9000
"""rows of a direction by which the simulation is calibrated anew: twenty for each of its numbers"""


def beyond_orders(
    values: FloatArray, regressors: Sequence[Regressor], frame: Frame, number: FloatArray, orders: Sequence[float]
) -> FloatArray:
    """Part of ``values`` (n,) that ``regressors`` of the offset and the amplitudes and phases of ``orders`` do not say,
    each a quadratic polynomial of torque, speed and temperature in each direction; rows of ``number`` (n,) samples.
    """
    out = values.copy()
    for side in (1, -1):
        rows = np.flatnonzero(frame.last_direction * side > 0)
        fitted = rows[number[rows] > 0]
        if not fitted.size:
            continue
        if fitted.size > MOST_ROWS:
            fitted = fitted[np.round(np.linspace(0, fitted.size - 1, MOST_ROWS)).astype(int)]
        states = frame.states[fitted]
        scaling = Scaling.of(states, states)
        normal = Normal()
        normal.add([_columns(regressors, frame, fitted, scaling, orders)], values[fitted], number[fitted])
        coefficients = normal.coefficients()
        for a in range(0, rows.size, ROWS_AT_ONCE):
            part = rows[a : a + ROWS_AT_ONCE]
            out[part] -= _columns(regressors, frame, part, scaling, orders) @ coefficients
    return out


def _columns(
    regressors: Sequence[Regressor], frame: Frame, rows: IntArray, scaling: Scaling, orders: Sequence[float]
) -> FloatArray:
    part = frame.take(rows)
    basis = scaling.monomials(part.states)
    angles = part.theta[:, None] * np.asarray(orders)
    waves = [wave[:, :, None] * basis[:, None, :] for wave in (np.cos(angles), np.sin(angles))]
    own = [
        columns_at(regressor, frame, rows) if remembers(regressor) else regressor.columns(part)
        for regressor in regressors
    ]
    return np.hstack([*own, *(wave.reshape(rows.size, -1) for wave in waves)])
