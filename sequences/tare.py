"""Slowly to and fro without load: the mean of both directions is the torque sensor's zero, friction cancels."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bench.protocols import Angle, BenchFacts, Phase, Point, Request, Segment, Speed
from sequences._bounds import require
from sequences._motion import finish, grid, start


@dataclass(frozen=True, slots=True)
class Tare:
    """One plateau each way over ``travel``; a multiple of the load motor's ripple periods averages its ripple out."""

    travel: Angle = math.pi / 3.0
    """Load side, rad: a sixth of a revolution holds whole periods of any motor's ripple (six times its pole pairs)."""
    speed: Speed = math.pi / 30.0
    """Load side, rad/s; by default 6 °/s."""
    kind: str = "free"
    prepares_temperature: bool = False

    def __post_init__(self) -> None:
        """Refuse options out of bounds (ValueError)."""
        require("travel", self.travel, 1e-3, 1e3, "rad")
        require("speed", self.speed, 1e-5, 1e3, "rad/s")

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return every combination of the request."""
        return grid(request)

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return the plateau forward, the turn, the plateau backward, to where it began."""
        reversal_s = bench.velocity_ramp_s(self.speed, -self.speed)
        hold = self.travel / self.speed
        return (
            *start(self.speed, 0.0, bench),
            Phase(Segment.STEADY, hold, self.speed, 0.0),
            Phase(None, reversal_s, -self.speed, 0.0),
            Phase(None, bench.settling_s, -self.speed, 0.0),
            Phase(Segment.STEADY, hold, -self.speed, 0.0),
            *finish(-self.speed, 0.0, bench),
        )
