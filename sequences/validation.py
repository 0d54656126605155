"""Sobol validation points (paper, "Model Validation"), measured like any constant-velocity point."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy.stats import qmc

from bench.protocols import BenchFacts, Phase, Point, Request
from sequences._bounds import require_whole
from sequences.constant_velocity import ConstantVelocity


@dataclass(frozen=True, slots=True)
class Validation:
    """``count`` points of a scrambled Sobol sequence inside the bounds of the identification grid.

    Four dimensions: load torque, speed magnitude, direction, temperature. Direction and magnitude are drawn apart,
    because a velocity drawn across zero would fall into the standstill the grid leaves out.
    """

    count: int = 19
    seed: int = 0
    kind: str = "validation"
    prepares_temperature: bool = True

    def __post_init__(self) -> None:
        """Refuse options out of bounds (ValueError)."""
        require_whole("count", self.count, 1, 4096)
        require_whole("seed", self.seed, 0, 2**63 - 1)

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return ``count`` points; torque and speed bounds are the extremes of the request, temperature runs from the
        lubricant's start to the highest requested.

        Raises
        ------
        ValueError
            If a bound is missing.
        """
        speeds = [abs(velocity) for velocity in request.velocities]
        wanted = [temperature for temperature in request.temperatures if temperature is not None]
        if min(speeds) == 0.0:
            raise ValueError("validation speeds must be other than zero")
        low, high = request.start_temperature, max(wanted, default=request.start_temperature)
        # Sobol points keep their balance only in powers of two: draw the next one up and take the first `count`
        sampler = qmc.Sobol(d=4, scramble=True, rng=self.seed)
        sample = sampler.random_base2(max(0, math.ceil(math.log2(self.count))))[: self.count]
        torques = request.load_torques
        return tuple(
            Point(
                request.sequence,
                round(min(torques) + u_torque * (max(torques) - min(torques)), 1),
                math.copysign(min(speeds) + u_speed * (max(speeds) - min(speeds)), u_direction - 0.5),
                round(low + u_temperature * max(0.0, high - low), 2),
                1,
                request.stage,
                request.options,
            )
            for u_torque, u_speed, u_direction, u_temperature in sample.tolist()
        )

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return the phases of a constant-velocity point."""
        return ConstantVelocity().phases(point, bench)
