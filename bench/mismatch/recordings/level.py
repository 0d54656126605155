"""The load where it is kept at a level, without the noise of the torque sensor.

A regression on a quantity that is read with noise mistakes the noise for the quantity (errors in variables): where a
load is kept, what the sensor reads about its level is mostly the sensor. A second witness tells how much of it is load:
the load motor's own torque, whose noise is not the sensor's. The share that both have in common is kept, and no more
("regression calibration", Carroll et al., Measurement Error in Nonlinear Models, 2006, chapter 4).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bench.identification.samples.spikes import spikes
from bench.mismatch import criteria
from bench.mismatch.recordings.smoothing import local_quadratic, repaired
from bench.recording import Recording
from bench.simulation.frame import FloatArray, Frame, IntArray

_LOOKED_AT = 6
"""recordings in which both witnesses are compared"""
_HUM, _FEWEST_PARTS = 0.1, 4
"""part of that time over which a load is averaged before it is asked whether it stays; parts of a segment at least"""
_FEWEST_MEANS = 20
"""means over :data:`criteria.KEPT_LOAD_S` from which a share can be estimated"""


def kept_segments(
    torque: FloatArray, label: IntArray, rests: NDArray[np.bool_], largest: float, rate: float
) -> list[IntArray]:
    """Samples of each segment in which a torque (n,) is kept at a level.

    ``label`` (n,) numbers the segments (-1: none), ``rests`` (n,) marks those in which the load may rest at a level,
    ``largest`` is the folder's largest torque in N·m.
    """
    segments = [np.flatnonzero((label == number) & rests) for number in np.unique(label) if number >= 0]
    return [rows for rows in segments if rows.size > 1 and _kept(torque[rows], rate, largest)]


def numbered(kept: Sequence[IntArray], size: int) -> FloatArray:
    """Number of the segment, from 1, that each of so many samples belongs to (n,); 0 for none."""
    out = np.zeros(size)
    for number, rows in enumerate(kept, start=1):
        out[rows] = number
    return out


def means_of_segments(values: FloatArray, frame: Frame) -> FloatArray:
    """Some values (n,) as the mean of their segment where a frame's load is kept at a level, elsewhere as they are."""
    kept = frame.kept.astype(np.int64)
    which = frame.recording * (1 + kept.max(initial=0)) + kept
    mean = np.bincount(which, frame.count * values) / np.maximum(np.bincount(which, frame.count), 1e-300)
    return np.where(frame.kept > 0, mean[which], values)


def levelled(
    values: FloatArray,
    kept: Sequence[IntArray],
    rate: float,
    confirmed: float = 1.0,
    beside: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """A torque (n,) with the noise of its sensor kept down in the segments that are ``kept``, and as their means.

    The first is the mean and the ``confirmed`` share of what is about it when it is smoothed over a second; and of what
    it does within the seconds, smoothed over a tenth of that, the share that a torque measured ``beside`` it (n,) does
    as well. Both are unchanged elsewhere.
    """
    smooth, level = values.copy(), values.copy()
    for rows in kept:
        part = values[rows]
        level[rows] = part.mean()
        smooth[rows] = part.mean() + confirmed * (local_quadratic(part, rate, criteria.KEPT_LOAD_S)[0] - part.mean())
        if beside is not None:
            quick = _within(part, rate)
            smooth[rows] += _share(_within(beside[rows], rate), quick) * quick
    return smooth, level


def confirmed(recordings: Sequence[Recording], largest: float) -> float:
    """Share of what the torque sensor reads about a level, second by second, that the load motor's torque has as well.

    The slope of the one on the other in the steady segments of some recordings, from 0 to 1; 1 where there is no second
    witness or too little to tell. ``largest``: the folder's largest torque in N·m.
    """
    both = [r for r in recordings if {"load_torque", "load_motor_torque"} <= set(r.specs) and r.steady()]
    common = energy = 0.0
    number = 0
    for recording in both[:: max(1, len(both) // _LOOKED_AT)]:
        width = max(1, round(criteria.KEPT_LOAD_S * float(recording.sample_rate)))
        for part in recording.steady():
            size = (part.stop - part.start) // width * width
            if size < 3 * width:
                continue
            values = recording.read_si(("load_torque", "load_motor_torque"), part.start, part.start + size)
            sensor, motor = (repaired(v, spikes(v)) for v in values.values())
            rate = float(recording.sample_rate)
            if not _kept(sensor, rate, largest) or not _kept(motor, rate, largest):
                continue
            x, z = (v.reshape(-1, width).mean(axis=1) - v.mean() for v in (sensor, motor))
            common += float(x @ z)
            energy += float(x @ x)
            number += x.size - 1
    if number < _FEWEST_MEANS or energy <= 0.0:
        return 1.0
    return float(np.clip(common / energy, 0.0, 1.0))


def _share(witness: FloatArray, values: FloatArray) -> float:
    """Share of some ``values`` (n,), from 0 to 1, that a ``witness`` (n,) has as well: the slope of it on them."""
    energy = float(values @ values)
    return float(np.clip(float(witness @ values) / energy, 0.0, 1.0)) if energy > 0.0 else 0.0


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
