"""A sequence of one's own in one file: the load goes slowly to and fro about zero with the input held at rest."""

from dataclasses import dataclass
from typing import Annotated

from bench.protocols import BenchFacts, Phase, Point, Request, Segment, Unit


@dataclass(frozen=True, slots=True)
class LostMotion:
    """Loops of load torque between plus and minus the point's torque; the flanks' distance is the lost motion."""

    loops: int = 2
    rate: Annotated[float, Unit("torque rate")] = 50.0
    """N·m/s"""
    kind: str = "torque_ramp"
    prepares_temperature: bool = True

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return a point for every torque and temperature; the input does not move."""
        return tuple(
            Point(request.sequence, torque, 0.0, temperature, repeat, request.stage, request.options)
            for temperature in request.temperatures
            for torque in request.load_torques
            for repeat in range(1, request.repeats + 1)
        )

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return the loops as one steady segment, and the way back to no load."""
        quarter = abs(point.load_torque) / self.rate
        up = Phase(Segment.STEADY, quarter, 0.0, point.load_torque)
        loop = (
            Phase(Segment.STEADY, 2.0 * quarter, 0.0, -point.load_torque),
            Phase(Segment.STEADY, 2.0 * quarter, 0.0, point.load_torque),
        )
        return (up, *(self.loops * loop), Phase(Segment.RAMP_DOWN, quarter, 0.0, 0.0))
