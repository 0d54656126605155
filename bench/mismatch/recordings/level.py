"""The load where it is kept at a level, without the noise of the torque sensor.

A regression on a quantity that is read with noise mistakes the noise for the quantity (errors in variables): where a
load is kept, what the sensor reads about its level is mostly the sensor. A second witness tells how much of it is load:
the load motor's own torque, whose noise is not the sensor's. The share that both have in common is kept, and no more
("regression calibration", Carroll et al., Measurement Error in Nonlinear Models, 2006, chapter 4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.identification.samples.spikes import spikes
from bench.mismatch import criteria
from bench.mismatch.recordings.smoothing import local_quadratic, repaired
from bench.recording import Recording
from bench.simulation.frame import FloatArray, IntArray

_LOOKED_AT = 6
"""recordings in which both witnesses are compared"""
_HUM, _FEWEST_PARTS = 0.1, 4
"""part of that time over which a load is averaged before it is asked whether it stays; parts of a segment at least"""
_FEWEST_MEANS = 20
"""means over :data:`criteria.KEPT_LOAD_S` from which a share can be estimated"""


@dataclass(frozen=True, slots=True)
class Shares:
    """How far the torque sensor and the load motor confirm each other about a kept load, from 0 to 1.

    ``slow``: of what the sensor reads about the level, second by second, the part that the load motor's torque has as
    well. ``quick``: of what the load motor reports within the seconds, the part that the sensor reads as well.
    """

    slow: float = 1.0
    quick: float = 0.0


ALONE = Shares()
"""of a sensor without a second witness"""


def levelled(
    torque: FloatArray,
    label: IntArray,
    rests: NDArray[np.bool_],
    largest: float,
    rate: float,
    slow: float = 1.0,
    quick: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """A torque (n,) with the noise of its sensor kept down where a segment keeps its load, and as the segment's mean.

    The first is the mean, the ``slow`` share of what is about it when it is smoothed over a second, and the ``quick``
    share of what it does within the seconds, smoothed over a tenth of that. ``label`` (n,) numbers the segments
    (-1: none), ``rests`` (n,) marks those in which the load may rest at a level, ``largest`` is the folder's largest
    torque in N·m. Both are unchanged elsewhere.
    """
    smooth, level = torque.copy(), torque.copy()
    for number in (int(v) for v in np.unique(label) if v >= 0):
        rows = np.flatnonzero((label == number) & rests)
        if rows.size < 2 or not _kept(torque[rows], rate, largest):
            continue
        part = torque[rows]
        level[rows] = part.mean()
        seconds = local_quadratic(part, rate, criteria.KEPT_LOAD_S)[0]
        smooth[rows] = part.mean() + slow * (seconds - part.mean())
        if quick > 0.0:
            smooth[rows] += quick * (local_quadratic(part, rate, _HUM * criteria.KEPT_LOAD_S)[0] - seconds)
    return smooth, level


def shares(recordings: Sequence[Recording], largest: float) -> Shares:
    """How far both torques confirm each other in the steady segments of some recordings.

    ``slow`` is the slope of the load motor's means over a second on the sensor's, ``quick`` that of what the sensor
    reads within the seconds on what the load motor reports. As if there were no second witness where too little is
    there to tell. ``largest``: the folder's largest torque in N·m.
    """
    both = [r for r in recordings if {"load_torque", "load_motor_torque"} <= set(r.specs) and r.steady()]
    slow, quick = np.zeros(2), np.zeros(2)
    number = 0
    for recording in both[:: max(1, len(both) // _LOOKED_AT)]:
        rate = float(recording.sample_rate)
        width = max(1, round(criteria.KEPT_LOAD_S * rate))
        for part in recording.steady():
            size = (part.stop - part.start) // width * width
            if size < 3 * width:
                continue
            values = recording.read_si(("load_torque", "load_motor_torque"), part.start, part.start + size)
            sensor, motor = (repaired(v, spikes(v)) for v in values.values())
            if not _kept(sensor, rate, largest) or not _kept(motor, rate, largest):
                continue
            x, z = (v.reshape(-1, width).mean(axis=1) - v.mean() for v in (sensor, motor))
            slow += x @ z, x @ x
            number += x.size - 1
            x, z = (_within(v, rate) for v in (sensor, motor))
            quick += x @ z, z @ z
    if number < _FEWEST_MEANS or slow[1] <= 0.0:
        return ALONE
    return Shares(_slope(*slow), _slope(*quick))


def _slope(common: float, energy: float) -> float:
    return float(np.clip(common / energy, 0.0, 1.0)) if energy > 0.0 else 0.0


def _within(torque: FloatArray, rate: float) -> FloatArray:
    """What a torque (n,) does within the seconds."""
    spans = (_HUM * criteria.KEPT_LOAD_S, criteria.KEPT_LOAD_S)
    quick, slow = (local_quadratic(torque, rate, span)[0] for span in spans)
    return np.asarray(quick - slow)


def _kept(torque: FloatArray, rate: float, largest: float) -> bool:
    """Whether a torque stays about one level: a staircase or a ramp spreads over far more than a controller's
    wavering. What swings within a part of :data:`criteria.KEPT_LOAD_S`, a shaft that hums, is no change of the load.
    """
    width = max(1, min(round(_HUM * criteria.KEPT_LOAD_S * rate), torque.size // _FEWEST_PARTS))
    parts = torque[: torque.size // width * width].reshape(-1, width).mean(axis=1)
    return float(np.std(parts)) < criteria.KEEPS_ITS_LOAD * max(largest, float(np.abs(torque.mean())))
