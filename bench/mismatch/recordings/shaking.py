"""How the load is shaken by the waves of the transmission error in steady motion.

A window that keeps the noise out of an acceleration keeps waves of forty hertz out as well, and at order 280 an inertia
of 3 kg·m² asks for a newton metre to follow eight microradians. What the window leaves of the angle is noise and waves;
each wave that stands out of the noise has the acceleration that follows from its order and the speed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import median_filter

from bench.mismatch import criteria
from bench.mismatch.recordings.notch import spectrum
from bench.simulation.frame import FloatArray
from bench.simulation.waves import of_orders

_SAMPLES_A_WAVE = 4
"""samples of the shortest wave that is looked for"""
_NEIGHBOURS = 31
"""waves about one whose median tells the noise at it"""
_SHORTEST = 200
"""samples of a segment in which waves are looked for"""


def shaken(angle: FloatArray, left: FloatArray, speed: FloatArray, pieces: Sequence[slice]) -> FloatArray:
    """Acceleration (n,), rad/s², of the waves over the output's ``angle`` (n,) that stand out of the noise in what a
    window ``left`` of it (n,), in each of some steady pieces; nothing elsewhere. ``speed`` (n,) of the output, rad/s.
    """
    out = np.zeros(angle.size)
    for piece in pieces:
        x, y = angle[piece], left[piece]
        travel = float(np.ptp(x))
        if y.size < _SHORTEST or travel <= 0.0 or not np.isfinite(y).all():
            continue
        unit = 2.0 * np.pi / travel
        found = 2.0 / y.size * spectrum((x - x[0]) * unit, y - y.mean(), y.size // _SAMPLES_A_WAVE)
        power = np.abs(found) ** 2
        power[0] = 0.0
        noise = median_filter(power, _NEIGHBOURS, mode="nearest") / np.log(2.0)
        clear = np.flatnonzero(power > criteria.LINE_POWER * np.maximum(noise, 1e-300))
        orders: FloatArray = np.asarray(clear * unit)
        bending = [np.asarray(-(orders**2) * part[clear]) for part in (found.real, found.imag)]
        out[piece] = of_orders(x - x[0], orders, *bending) * speed[piece] ** 2
    return out
