"""What all sequences share: from rest to a loaded motion, back to rest, and the plain grid of points."""

from __future__ import annotations

from itertools import product

from bench.protocols import BenchFacts, Phase, Point, Request, Segment


def start(velocity: float, load_torque: float, bench: BenchFacts) -> tuple[Phase, ...]:
    """Speed first, then the load, then a wait until transients have decayed; an input at rest is never loaded."""
    return (
        Phase(Segment.RAMP_UP, bench.velocity_ramp_s(0.0, velocity), velocity, 0.0),
        Phase(Segment.RAMP_UP, bench.torque_ramp_s(0.0, load_torque), velocity, load_torque),
        Phase(Segment.RAMP_UP, bench.settling_s, velocity, load_torque),
    )


def finish(velocity: float, load_torque: float, bench: BenchFacts) -> tuple[Phase, ...]:
    """The load is taken off before the input stops."""
    return (
        Phase(Segment.RAMP_DOWN, bench.torque_ramp_s(load_torque, 0.0), velocity, 0.0),
        Phase(Segment.RAMP_DOWN, bench.velocity_ramp_s(velocity, 0.0), 0.0, 0.0),
    )


def grid(request: Request) -> tuple[Point, ...]:
    """Every combination; repeats outermost, then temperatures, so that repeats lie apart in time."""
    repeats = range(1, request.repeats + 1)
    return tuple(
        Point(request.sequence, torque, velocity, temperature, repeat, request.stage, request.options)
        for repeat, temperature, torque, velocity in product(
            repeats, request.temperatures, request.load_torques, request.velocities
        )
    )
