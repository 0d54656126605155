"""How the load is shaken by the waves of the transmission error in steady motion.

A window that keeps the noise out of an acceleration keeps waves of forty hertz out as well, and at order 280 an inertia
of 3 kg·m² asks for a newton metre to follow eight microradians. What a window leaves of the angle is noise and the
greater part of such waves. Each that stands out of the noise has the acceleration that follows from its order and the
speed; what the smoothed acceleration lacks of it is added. What is left is that of a wider window: a window lets pass
more of a wave than of its acceleration. Where the motor's acceleration stands for the load's, what both shafts do
together is in it already.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch.recordings.late import Complex
from bench.mismatch.recordings.notch import spectrum, standing_out
from bench.mismatch.recordings.smoothing import local_quadratic, passed_by, value_passed_by, window
from bench.recording import Recording
from bench.simulation.frame import FloatArray
from bench.simulation.waves import of_orders

_SAMPLES_A_WAVE = 4
"""samples of the shortest wave that is looked for"""
_SHORTEST = 600
"""samples of a segment in which waves are looked for: five times the waves whose median tells the noise"""
_LEAST_TRAVEL = 2.0 * np.pi / 6.0
"""rad of the output in such a segment"""
_WIDER = 4.0
"""times the window of the acceleration that of the angle is which leaves the waves"""
_LEAST_LEFT = 0.2
"""share of a wave that the wider window has to leave: of one that it lets pass the smoothed acceleration knows"""
_COUNTS = 0.5
"""counts of the encoder that a wave has at least: an even motion over the steps of a coarse one has waves of a third"""


def shaken(
    angle: FloatArray,
    speed: FloatArray,
    pieces: Sequence[slice],
    rate: float,
    span: float,
    count: float = 0.0,
    motor: FloatArray | None = None,
) -> FloatArray:
    """What an acceleration lacks (n,), rad/s², of the waves over the output's ``angle`` (n,) that stand out of the
    noise in what a window :data:`_WIDER` times as long leaves of it, in each of some steady pieces; nothing elsewhere.

    ``speed`` (n,) of the output, rad/s; sample ``rate`` in Hz; ``span`` of the acceleration's window in s; ``count`` of
    the angle's encoder, rad. ``motor`` (n,): the motor's angle over the ratio, where the acceleration is its; else it
    is that of the output's angle.
    """
    wide = _WIDER * span
    out = np.zeros(angle.size)
    for piece in pieces:
        x = angle[piece]
        if x.size < max(_SHORTEST, 2 * window(rate, wide)) or not np.isfinite(x).all():
            continue
        travel = float(np.ptp(x))
        if travel < _LEAST_TRAVEL:
            continue
        # over whole revolutions whole orders do not leak into each other
        period = 2.0 * np.pi * np.floor(travel / (2.0 * np.pi)) or travel
        within = np.abs(x - x[0]) <= period
        unit = 2.0 * np.pi / period
        turned, number = (x - x[0])[within] * unit, int(within.sum())
        found = _clear_waves(turned, _left(x, rate, wide)[within])
        known = found if motor is None else _clear_waves(turned, _left(motor[piece], rate, wide)[within])
        clear = np.flatnonzero(found)
        hertz = clear * rate / number
        share = 1.0 - value_passed_by(rate, wide, hertz)
        real = (share > _LEAST_LEFT) & (np.abs(found[clear]) > _COUNTS * count * share)
        orders: FloatArray = np.asarray(clear[real] * unit, dtype=np.float64)
        lacking = found[clear[real]] - known[clear[real]] * passed_by(rate, span, hertz[real])
        bending = -(orders**2) * lacking / share[real]
        out[piece] = of_orders(x - x[0], orders, np.asarray(bending.real), np.asarray(bending.imag)) * speed[piece] ** 2
    return out


def _left(angle: FloatArray, rate: float, span: float) -> FloatArray:
    """What a window leaves of an angle (n,)."""
    return np.asarray(angle - local_quadratic(angle, rate, span)[0])


def _clear_waves(turned: FloatArray, left: FloatArray) -> Complex:
    """Waves of what is ``left`` (n,) over an angle (n,) of some whole periods that stand out of the noise; else 0."""
    waves = 2.0 / left.size * spectrum(turned, left - left.mean(), left.size // _SAMPLES_A_WAVE)
    return np.where(standing_out(waves), waves, 0.0)


def count_of(recording: Recording) -> float:
    """Count of the encoder of a recording's output, rad: as it is recorded; 0 where it is not recorded in counts."""
    spec = recording.specs["load_angle"]
    return abs(spec.scale) if np.issubdtype(np.dtype(spec.dtype), np.integer) else 0.0
