"""How the load is shaken by the waves of the transmission error in steady motion.

A window that keeps the noise out of an acceleration keeps waves of forty hertz out as well, and at order 280 an inertia
of 3 kg·m² asks for a newton metre to follow eight microradians. What a window leaves of the angle is noise and the
greater part of such waves. Each that stands out of the noise has the acceleration that follows from its order and the
speed; what the smoothed acceleration lacks of it is added. What is left is that of a wider window, for a window lets pass more of a wave than of its acceleration.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch.recordings.notch import spectrum, standing_out
from bench.mismatch.recordings.smoothing import passed_by, value_passed_by
from bench.recording import Recording
from bench.simulation.frame import FloatArray
from bench.simulation.waves import of_orders

_SAMPLES_A_WAVE = 4
"""samples of the shortest wave that is looked for"""
_SHORTEST = 600
"""samples of a segment in which waves are looked for: five times the waves whose median tells the noise"""
_LEAST_TRAVEL = 2.0 * np.pi / 6.0
"""rad of the output in such a segment"""
_LEAST_LEFT = 0.2
"""share of a wave that the wider window has to leave: of one that it lets pass the smoothed acceleration knows"""
WIDER = 4.0
"""times the window of the acceleration that of the angle is which leaves the waves"""
_COUNTS = 0.5
"""counts of the encoder that a wave has at least: an even motion over the steps of a coarse one has waves of a third"""


def shaken(
    angle: FloatArray,
    left: FloatArray,
    speed: FloatArray,
    pieces: Sequence[slice],
    rate: float,
    span: float,
    count: float = 0.0,
    smoothed: bool = True,
) -> FloatArray:
    """What an acceleration lacks (n,), rad/s², of the waves over the output's ``angle`` (n,) that stand out of the
    noise in what a window :data:`WIDER` times as long ``left`` of it (n,), in each of some steady pieces; nothing
    elsewhere.

    ``speed`` (n,) of the output, rad/s; sample ``rate`` in Hz; ``span`` of the acceleration's window in s; ``count`` of
    the angle's encoder, rad. ``smoothed``: whether the acceleration is that of the angle behind its window; else it has
    no waves.
    """
    out = np.zeros(angle.size)
    for piece in pieces:
        x, y = angle[piece], left[piece]
        travel = float(np.ptp(x)) if y.size else 0.0
        if y.size < _SHORTEST or travel < _LEAST_TRAVEL or not np.isfinite(y).all():
            continue
        turned = np.abs(x - x[0])
        # over whole revolutions whole orders do not leak into each other
        period = 2.0 * np.pi * np.floor(travel / (2.0 * np.pi)) or travel
        within = turned <= period
        unit = 2.0 * np.pi / period
        number = int(within.sum())
        found = (
            2.0
            / number
            * spectrum((x - x[0])[within] * unit, (y - y[within].mean())[within], number // _SAMPLES_A_WAVE)
        )
        clear = np.flatnonzero(standing_out(found))
        hertz = clear * rate / number
        share = 1.0 - value_passed_by(rate, WIDER * span, hertz)
        waves = found[clear] / share
        real = (share > _LEAST_LEFT) & (np.abs(waves) > _COUNTS * count)
        orders: FloatArray = np.asarray(clear[real] * unit, dtype=np.float64)
        lacking = 1.0 - passed_by(rate, span, hertz[real]) if smoothed else np.ones(orders.size)
        bending = -(orders**2) * lacking * waves[real]
        out[piece] = of_orders(x - x[0], orders, np.asarray(bending.real), np.asarray(bending.imag)) * speed[piece] ** 2
    return out


def count_of(recording: Recording) -> float:
    """Count of the encoder of a recording's output, rad: as it is recorded; 0 where it is not recorded in counts."""
    spec = recording.specs["load_angle"]
    return abs(spec.scale) if np.issubdtype(np.dtype(spec.dtype), np.integer) else 0.0
