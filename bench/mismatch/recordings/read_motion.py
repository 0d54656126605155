"""The motion of the motor without what its encoder misreads.

An eccentric disc is wrong by a wave over the motor's revolution: the angle reads u*w less, for a wave w that the
transmission error shows. The speed and the acceleration that are taken from the angle have the wave's derivatives,
which move no rotor and ask for no torque.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch.recordings.smoothing import passed_by
from bench.simulation.frame import Frame
from bench.simulation.waves import Wave, evaluate, kept_by_mean


def without_misread_motion(frame: Frame, waves: Sequence[Wave], rate: float, span: float) -> Frame:
    """A frame whose velocity and acceleration are those of the motor and not of its encoder.

    ``waves`` of the transmission error (rad over the output angle) that the encoder makes; ``rate`` of the samples in
    Hz, from which rates were smoothed over ``span`` s.
    """
    velocity, acceleration = frame.velocity.copy(), frame.acceleration.copy()
    turned = np.abs(frame.velocity) * frame.count / rate
    for wave in waves:
        slope = evaluate([wave.slope], frame.theta, frame)
        curve = evaluate([wave.slope.slope], frame.theta, frame)
        kept = kept_by_mean(wave.order, turned)
        kept *= passed_by(rate, span, wave.order * np.abs(frame.velocity) / (2.0 * np.pi))
        velocity += kept * slope * frame.velocity
        acceleration += kept * (frame.ratio * curve * frame.velocity**2 + slope * frame.acceleration)
    return replace(frame, velocity=velocity, acceleration=acceleration)
