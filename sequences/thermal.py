"""Heating, cooling and dwelling: what brings the lubricant to a temperature or watches it there."""

from __future__ import annotations

from dataclasses import dataclass

from bench.protocols import BenchFacts, Phase, Point, Request, Segment, Time, Until
from sequences._bounds import LONGEST_S, require
from sequences._motion import grid


def _target(point: Point, name: str) -> float:
    if point.temperature is None:
        raise ValueError(f"a {name} point needs a temperature to end at")
    return point.temperature


@dataclass(frozen=True, slots=True)
class Heating:
    """High speed without load until a hysteresis above the point's temperature, then a soak at rest."""

    direction: int = 1
    kind: str = "heating"
    prepares_temperature: bool = False

    def __post_init__(self) -> None:
        """Refuse a direction that is none (ValueError)."""
        if self.direction not in (-1, 1):
            raise ValueError(f"direction is {self.direction}, it must be 1 or -1")

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return one point a temperature of the request."""
        return grid(request)

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return ramp, heating until warm, ramp and soak; ValueError without a temperature."""
        threshold = _target(point, "heating") + bench.heating_hysteresis
        velocity = self.direction * bench.heating_motor_speed / bench.ratio
        ramp = bench.velocity_ramp_s(0.0, velocity)
        return (
            Phase(Segment.RAMP_UP, ramp, velocity, 0.0),
            Phase(Segment.HEAT, bench.heating_time_limit_s, velocity, 0.0, Until.WARMER, threshold),
            Phase(Segment.RAMP_DOWN, ramp, 0.0, 0.0),
            Phase(Segment.DWELL, bench.heating_soak_s, 0.0, 0.0),
        )


@dataclass(frozen=True, slots=True)
class Cooling:
    """Rest without load until the lubricant has cooled to the point's temperature."""

    time_limit: Time = 6 * 3600.0
    kind: str = "cooling"
    prepares_temperature: bool = False

    def __post_init__(self) -> None:
        """Refuse options out of bounds (ValueError)."""
        require("time_limit", self.time_limit, 0.0, LONGEST_S, "s")

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return one point a temperature of the request."""
        return grid(request)

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return one dwell that ends when cool; ValueError without a temperature."""
        return (Phase(Segment.DWELL, self.time_limit, 0.0, 0.0, Until.COOLER, _target(point, "cooling")),)


@dataclass(frozen=True, slots=True)
class Dwell:
    """Rest under the point's load torque for a time: shows sensor zero, creep and drift."""

    duration: Time = 30.0
    kind: str = "dwell"
    prepares_temperature: bool = True

    def __post_init__(self) -> None:
        """Refuse options out of bounds (ValueError)."""
        require("duration", self.duration, 0.0, LONGEST_S, "s")

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return every combination of the request."""
        return grid(request)

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return load on, dwell, load off, all at rest."""
        ramp = bench.torque_ramp_s(0.0, point.load_torque)
        return (
            Phase(Segment.RAMP_UP, ramp, 0.0, point.load_torque),
            Phase(Segment.DWELL, self.duration, 0.0, point.load_torque),
            Phase(Segment.RAMP_DOWN, ramp, 0.0, 0.0),
        )
