"""What a given simulation has that is periodic in the angle beside its series: pulses, and laws of the amplitudes.

They are in force as they stand in the file, with the file's numbers: a pulse is taken off the measured transmission
error, a law divides the orders' vectors before the series is calibrated on them and multiplies what it predicts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.laws import Complex, Law, factor


@dataclass(frozen=True, slots=True)
class Pulse:
    """A Gaussian pulse of the transmission error: angle and width (standard deviation) in rad, height in rad."""

    angle: float
    width: float
    height: float

    def evaluate(self, theta: FloatArray) -> FloatArray:
        """The pulse at angles (n,), rad."""
        distance = np.mod(theta - self.angle + np.pi, 2.0 * np.pi) - np.pi
        return np.asarray(self.height * np.exp(-0.5 * (distance / self.width) ** 2))


@dataclass(frozen=True, slots=True)
class Periodic:
    """Pulses and laws of a given simulation; empty for the nominal one."""

    pulses: tuple[Pulse, ...] = ()
    laws: tuple[Law, ...] = ()

    def pulses_at(self, frame: Frame) -> FloatArray:
        """Sum of the pulses at the rows of a frame, rad."""
        out = np.zeros(frame.size)
        for pulse in self.pulses:
            out += pulse.evaluate(frame.theta)
        return out

    def factor(self, x: FloatArray, time: FloatArray, orders: Sequence[float]) -> Complex:
        """Product of the laws at states (n, 3) and times (n,), (n, orders)."""
        out = np.ones((len(x), len(orders)), dtype=np.complex128)
        for law in self.laws:
            out = out * factor(law, x, time, orders)
        return out


NOTHING = Periodic()
