"""Sequences that separate effects: reversals, torque staircases, velocity ramps, and the run-in before a campaign."""

from __future__ import annotations

from dataclasses import dataclass

from bench.protocols import Angle, BenchFacts, Phase, Point, Request, Segment, Time
from sequences._bounds import LONGEST_S, require, require_whole
from sequences._motion import finish, grid, start


@dataclass(frozen=True, slots=True)
class Reversal:
    """To and fro over ``amplitude`` (load side, peak to peak of the plateaus) under a constant preload.

    Backlash vanishes under preload, hysteresis grows with amplitude and not with rate, Coulomb friction switches at
    once.
    """

    amplitude: Angle = 0.2
    cycles: int = 3
    kind: str = "reversal"
    prepares_temperature: bool = True

    def __post_init__(self) -> None:
        """Refuse options out of bounds (ValueError)."""
        require("amplitude", self.amplitude, 1e-6, 1e4, "rad")
        require_whole("cycles", self.cycles, 1, 10_000)

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return every combination of the request."""
        return grid(request)

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return the plateaus, alternating in direction; ValueError without a velocity."""
        if point.velocity == 0.0:
            raise ValueError("a reversal point needs a velocity other than zero")
        torque, plateau = point.load_torque, self.amplitude / abs(point.velocity)
        reversal_s = bench.velocity_ramp_s(point.velocity, -point.velocity)
        phases = list(start(point.velocity, torque, bench))
        velocity = point.velocity
        for half in range(2 * self.cycles):
            if half:
                velocity = -velocity
                phases.append(Phase(None, reversal_s, velocity, torque))
            phases.append(Phase(Segment.STEADY, plateau, velocity, torque))
        return (*phases, *finish(velocity, torque, bench))


@dataclass(frozen=True, slots=True)
class TorqueRamp:
    """A staircase of load torque at constant velocity: 0 → +load_torque → −load_torque → 0 in ``steps`` a quarter."""

    steps: int = 5
    hold: Time = 2.0
    kind: str = "torque_ramp"
    prepares_temperature: bool = True

    def __post_init__(self) -> None:
        """Refuse options out of bounds (ValueError)."""
        require_whole("steps", self.steps, 1, 1000)
        require("hold", self.hold, 0.0, LONGEST_S, "s")

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return every combination of the request."""
        return grid(request)

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return the staircase as one steady segment."""
        levels = [point.load_torque * step / self.steps for step in range(self.steps + 1)]
        staircase = [*levels, *levels[-2::-1], *(-level for level in levels[1:]), *(-level for level in levels[-2::-1])]
        velocity, before = point.velocity, 0.0
        phases = list(start(velocity, 0.0, bench))
        for level in staircase:
            phases.append(Phase(Segment.STEADY, bench.torque_ramp_s(before, level), velocity, level))
            phases.append(Phase(Segment.STEADY, self.hold, velocity, level))
            before = level
        return (*phases, *finish(velocity, before, bench))


@dataclass(frozen=True, slots=True)
class VelocityRamp:
    """Slowly up to the point's velocity and down again under constant load: friction over the whole range of speeds."""

    duration: Time = 30.0
    """One way."""
    kind: str = "velocity_ramp"
    prepares_temperature: bool = True

    def __post_init__(self) -> None:
        """Refuse options out of bounds (ValueError)."""
        require("duration", self.duration, 0.0, LONGEST_S, "s")

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return every combination of the request."""
        return grid(request)

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return the two ramps, the load put on and taken off at rest."""
        ramp = bench.torque_ramp_s(0.0, point.load_torque)
        way = max(self.duration, bench.velocity_ramp_s(0.0, point.velocity))
        return (
            Phase(Segment.RAMP_UP, ramp, 0.0, point.load_torque),
            Phase(Segment.RAMP_UP, way, point.velocity, point.load_torque),
            Phase(Segment.RAMP_DOWN, way, 0.0, point.load_torque),
            Phase(Segment.RAMP_DOWN, ramp, 0.0, 0.0),
        )


@dataclass(frozen=True, slots=True)
class RunIn:
    """Both directions without measuring anything: spreads the lubricant and settles bearings before a campaign."""

    duration: Time = 30.0
    """Each direction."""
    kind: str = "free"
    prepares_temperature: bool = False

    def __post_init__(self) -> None:
        """Refuse options out of bounds (ValueError)."""
        require("duration", self.duration, 0.0, LONGEST_S, "s")

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return every combination of the request."""
        return grid(request)

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return forward and backward motion under the point's load; ValueError without a velocity."""
        if point.velocity == 0.0:
            raise ValueError("a run-in needs a velocity other than zero")
        velocity, torque = point.velocity, point.load_torque
        return (
            *start(velocity, torque, bench),
            Phase(None, self.duration, velocity, torque),
            Phase(None, bench.velocity_ramp_s(velocity, -velocity), -velocity, torque),
            Phase(None, self.duration, -velocity, torque),
            *finish(-velocity, torque, bench),
        )
