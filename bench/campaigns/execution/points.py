"""The points of one run: their numbers, their identities, and how they and recordings of them are called."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from bench.campaigns.listener import Expected
from bench.campaigns.planning.schedule import Task
from bench.campaigns.taken import point_id
from bench.names import require_name
from bench.protocols import Point


@dataclass(frozen=True, slots=True)
class Points:
    """Every point in the order of the plan; ``digest`` is that of the bench file they are measured under."""

    expected: tuple[Expected, ...]
    digest: str

    @classmethod
    def numbered(cls, stages: Sequence[Sequence[Point]], digest: str, done: set[str]) -> Points:
        """Number the points of all stages from 1; ``done`` are the identities that an earlier run has measured."""
        every = enumerate((point for points in stages for point in points), 1)
        return cls(tuple(Expected(n, id_ := point_id(p, digest), p, id_ in done) for n, p in every), digest)

    def identity(self, point: Point) -> str:
        """What a point is, by content and bench file."""
        return point_id(point, self.digest)

    def where(self, task: Task) -> str:
        """Return a task as an alarm names it: the point's number, speed and load."""
        point = task.prepares or task.point
        number = next((expected.number for expected in self.expected if expected.point == point), None)
        place = "a further point" if number is None else f"point {number}"
        heating = "the heating for " if task.is_preparation else ""
        return f"{heating}{place} ({math.degrees(point.velocity):.3g} °/s, {point.load_torque:.4g} N·m)"

    def name(self, task: Task, identity: str, kind: str, take: int) -> str:
        """Return the id of a recording: of a point by its number, of a heating by its identity."""
        if task.is_preparation:
            return f"heating-{identity[:6]}-{take:02d}"
        number = next(expected.number for expected in self.expected if expected.identity == identity)
        again = f"-take{take}" if take > 1 else ""
        return require_name(f"{number:04d}-{kind}{again}", "the recording id")
