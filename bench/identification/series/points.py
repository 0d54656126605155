"""Errors that recordings of one speed, or of one speed and torque, share in the transmission error.

An encoder's counting and a drive's loop that answers to it repeat themselves at the same point: recordings there do not
average them out. Those of a point are estimated from the scatter of the points' residuals; those of a whole speed are
what the polynomials of the speed take for themselves, so they come from what counting can do (:func:`.counting_bias`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bench.identification.samples.motion import SPEED_LEVEL, TORQUE_LEVEL, levels
from bench.identification.series.inputs import Design
from bench.identification.statistics.shared import Means, shared_covariance

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def _of_level(values: FloatArray, gap: float) -> IntArray:
    """Number (R,) of the level that each recording's value belongs to; levels are further apart than ``gap``."""
    return levels(values, np.ones(values.size), np.arange(values.size), np.ones(values.size, dtype=bool), gap)


def speeds_of(design: Design) -> IntArray:
    """Number (R,) of each recording's speed."""
    return _of_level(np.asarray(np.log(np.maximum(np.abs(design.inputs[:, 1]), 1e-9))), SPEED_LEVEL)


def points_of(design: Design) -> IntArray:
    """Number (R,) of each recording's pair of speed and torque."""
    torque = design.inputs[:, 0]
    step = TORQUE_LEVEL * max(float(np.ptp(torque)), 1e-12)
    return np.asarray(_of_level(torque, step) + 2 * torque.size * speeds_of(design))


def counting_covariance(design: Design, bias: FloatArray, effect: FloatArray) -> FloatArray:
    """What the encoder's counting adds to a covariance (P, P): one error for all recordings of one speed.

    ``bias`` (R,) is its standard deviation in each recording, ``effect`` (P, R) what an error of each does.
    """
    speed = speeds_of(design)
    shift = np.stack([effect[:, speed == number] @ bias[speed == number] for number in np.unique(speed)])
    return np.asarray(shift.T @ shift)


def points_covariance(design: Design, covariance: FloatArray, residual: FloatArray, variance: FloatArray) -> FloatArray:
    """What errors shared at points add to the ``covariance`` (P, P) of a fit with weights 1/``variance`` (R,)."""
    effect = covariance @ (design.regressors.T / variance)
    means = Means(residual, variance / variance.mean(), design.regressors, effect)
    return shared_covariance(means, [points_of(design)])[0]
