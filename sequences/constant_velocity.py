"""Constant-velocity sweep under constant load torque (paper, "Parameter Identification")."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bench.protocols import BenchFacts, Phase, Point, Request, Segment
from sequences._bounds import require
from sequences._motion import finish, grid, start

_MARGIN = 0.01
"""Part of a revolution more than asked for, so that following errors never leave the last one incomplete."""


@dataclass(frozen=True, slots=True)
class ConstantVelocity:
    """Ramps up, holds the speed for full load-side ``revolutions``, then ramps back to rest."""

    revolutions: float = 1.0
    kind: str = "constant_velocity"
    prepares_temperature: bool = True

    def __post_init__(self) -> None:
        """Refuse options out of bounds (ValueError)."""
        require("revolutions", self.revolutions, 1e-3, 1e4)

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return every combination of the request."""
        return grid(request)

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return ramps and steady motion.

        Raises
        ------
        ValueError
            If the point has no velocity, because it would never complete a revolution.
        """
        if point.velocity == 0.0:
            raise ValueError("a constant-velocity point needs a velocity other than zero; use dwell for standstill")
        duration = (self.revolutions + _MARGIN) * 2.0 * math.pi / abs(point.velocity)
        return (
            *start(point.velocity, point.load_torque, bench),
            Phase(Segment.STEADY, duration, point.velocity, point.load_torque),
            *finish(point.velocity, point.load_torque, bench),
        )
