"""What the load torque has without a name, beside the transmission error and the motor torque: an error of the sensor,
or a real change of the load within a segment whose load was replaced by its mean. Either changes the transmission error
by the compliance, and the motor torque by the ratio.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.mismatch.recordings.level import means_of_segments
from bench.mismatch.regression.model import ChannelModel
from bench.mismatch.regression.nameless import NamelessCourse
from bench.mismatch.regression.problem import BaseTerm, Untold
from bench.simulation.frame import FloatArray, Frame


@dataclass(frozen=True, slots=True)
class NamelessLoad(Untold):
    """What the load torque has without a name, N·m, in two parts with a coefficient each, for nothing tells an error
    from a load: as the torque that the simulation is given follows it, which shows an error of the sensor, and what
    that averages out where the load is kept at a level, which shows a load.
    """

    course: NamelessCourse
    words: str = "what the load torque has without a name"
    equation: str = "TE += dtau/K, tau_m += dtau/u"

    def columns(self, frame: Frame) -> FloatArray:
        """Both parts of the functions without a name at the rows of a frame (n, 2)."""
        whole = self.course.at(frame)
        averaged = (1.0 - frame.followed) * (whole - means_of_segments(whole, frame))
        return np.column_stack([whole - averaged, averaged])


def nameless_load(model: ChannelModel, most: float | None = None) -> tuple[BaseTerm, ...]:
    """The base term of another channel for a model of the load torque; none where all that it has is named.

    ``most``: prior standard deviation of its coefficients, 1/u in the motor torque; None where they are free.
    """
    precision = () if most is None else (1.0 / most**2,) * 2
    return (BaseTerm(NamelessLoad(NamelessCourse.of(model)), precision),) if model.nameless else ()
