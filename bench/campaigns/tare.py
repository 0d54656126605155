"""The torque sensor's zero, measured before and after a campaign by a slow motion both ways without load."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.cycle.channels import Scaling
from bench.errors import DeviceError
from bench.protocols import Point, Segment

TARE = Point("tare")
"""The motion, as a point of its own: it stands at the beginning and at the end of every plan."""


class TareSink:
    """Averages the torque sensor over the plateaus of either direction; keeps nothing else."""

    def __init__(self, scaling: Scaling) -> None:
        self._scaling = scaling
        self._steady = False
        self._sums: dict[bool, float] = {True: 0.0, False: 0.0}
        self._counts: dict[bool, int] = {True: 0, False: 0}

    def segment(self, segment: Segment | None) -> None:
        """Only steady motion counts."""
        self._steady = segment is Segment.STEADY

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        """Add a block to its direction."""
        if not self._steady or raw["cycle"].size == 0:
            return
        setpoint = raw["motor_velocity_setpoint"] * self._scaling.scale("motor_velocity_setpoint")
        for forward in (True, False):
            chosen = raw["load_torque"][(setpoint > 0.0) == forward]
            self._sums[forward] += float(chosen.sum(dtype=np.int64))
            self._counts[forward] += chosen.size

    def event(self, level: str, text: str) -> None:
        """Events of a tare are not kept."""

    @property
    def zero(self) -> float:
        """Mean of both directions in N·m, beyond what is tared already.

        Raises
        ------
        DeviceError
            If one direction is missing.
        """
        if not all(self._counts.values()):
            raise DeviceError("the tare motion did not turn both ways, the torque sensor's zero is not known")
        means = [self._sums[forward] / self._counts[forward] for forward in (True, False)]
        value = sum(means) / 2.0 * self._scaling.scale("load_torque") + self._scaling.offset("load_torque")
        return value
