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

from bench.mismatch.recordings.notch import Complex, spectrum, standing_out
from bench.mismatch.recordings.smoothing import passed_by, value_passed_by, window
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
    motor: FloatArray | None = None,
) -> FloatArray:
    """What an acceleration lacks (n,), rad/s², of the waves over the output's ``angle`` (n,) that stand out of the
    noise in what a window :data:`WIDER` times as long ``left`` of it (n,), in each of some steady pieces; nothing
    elsewhere.

    ``speed`` (n,) of the output, rad/s; sample ``rate`` in Hz; ``span`` of the acceleration's window in s; ``count`` of
    the angle's encoder, rad. ``motor`` (n,): where the acceleration is that of the motor over the ratio, what the wider
    window left of the motor's angle over the ratio; else it is that of the angle behind its window.
    """
    out = np.zeros(angle.size)
    for piece in pieces:
        x, y = angle[piece], left[piece]
        travel = float(np.ptp(x)) if y.size else 0.0
        if (
            y.size < max(_SHORTEST, 2 * window(rate, WIDER * span))
            or travel < _LEAST_TRAVEL
            or not np.isfinite(y).all()
        ):
            continue
        # over whole revolutions whole orders do not leak into each other
        period = 2.0 * np.pi * np.floor(travel / (2.0 * np.pi)) or travel
        within = np.abs(x - x[0]) <= period
        unit = 2.0 * np.pi / period
        turned, number = (x - x[0])[within] * unit, int(within.sum())
        found = _spectrum(turned, y[within])
        of_motor = np.zeros_like(found) if motor is None else _spectrum(turned, motor[piece][within])
        clear = np.flatnonzero(standing_out(found) | standing_out(of_motor))
        hertz = clear * rate / number
        share = 1.0 - value_passed_by(rate, WIDER * span, hertz)
        real = (share > _LEAST_LEFT) & (np.abs(found[clear]) > _COUNTS * count * share)
        orders: FloatArray = np.asarray(clear[real] * unit, dtype=np.float64)
        known = (found if motor is None else of_motor)[clear[real]] * passed_by(rate, span, hertz[real])
        bending = -(orders**2) * (found[clear[real]] - known) / share[real]
        out[piece] = of_orders(x - x[0], orders, np.asarray(bending.real), np.asarray(bending.imag)) * speed[piece] ** 2
    return out


def _spectrum(turned: FloatArray, left: FloatArray) -> Complex:
    """Waves of what is ``left`` (n,) over an angle (n,) of some whole periods."""
    highest = left.size // _SAMPLES_A_WAVE
    return 2.0 / left.size * spectrum(turned, left - left.mean(), highest)


def count_of(recording: Recording) -> float:
    """Count of the encoder of a recording's output, rad: as it is recorded; 0 where it is not recorded in counts."""
    spec = recording.specs["load_angle"]
    return abs(spec.scale) if np.issubdtype(np.dtype(spec.dtype), np.integer) else 0.0
