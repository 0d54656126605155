"""The motion of the motor without what its encoder misreads.

An eccentric disc is wrong by a wave over the motor's revolution: the angle reads u*w less, for a wave w that the
transmission error shows. The speed and the acceleration that are taken from the angle have the wave's derivatives,
which move no rotor and ask for no torque.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch.recordings.smoothing import passed_by
from bench.mismatch.regression.noise import durations
from bench.simulation.frame import FloatArray, Frame, recording_starts
from bench.simulation.waves import Wave, evaluate, kept_by_mean


def without_misread_motion(frame: Frame, waves: Sequence[Wave], span: float) -> Frame:
    """A frame whose velocity and acceleration are those of the motor and not of its encoder.

    ``waves`` of the transmission error (rad over the output angle) that the encoder makes; rates were smoothed over
    ``span`` s, of the samples of each recording.
    """
    if not waves or not frame.size:
        return frame
    velocity, acceleration = frame.velocity.copy(), frame.acceleration.copy()
    lasts = durations(frame)
    turned = np.abs(frame.velocity) * lasts
    for wave in waves:
        slope = evaluate([wave.slope], frame.theta, frame)
        curve = evaluate([wave.slope.slope], frame.theta, frame)
        kept = kept_by_mean(wave.order, turned)
        kept *= _passed(frame, lasts, span, wave.order * np.abs(frame.velocity) / (2.0 * np.pi))
        velocity += kept * slope * frame.velocity
        acceleration += kept * (frame.ratio * curve * frame.velocity**2 + slope * frame.acceleration)
    return replace(frame, velocity=velocity, acceleration=acceleration)


def _passed(frame: Frame, lasts: FloatArray, span: float, hertz: FloatArray) -> FloatArray:
    """Share (n,) of an acceleration at frequencies (n,) in Hz that the window of each row's recording lets pass; rows
    last ``lasts`` s (n,).
    """
    out = np.empty(frame.size)
    for a, b in itertools.pairwise(recording_starts(frame)):
        out[a:b] = passed_by(float(frame.count[a] / lasts[a]), span, hertz[a:b])
    return out
