"""Which point comes next, and whether the lubricant must be warmed for it first.

The same generator drives the plan (with an estimated temperature) and the run (with the measured one), so that a plan
shows what a run does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from bench.campaigns.planning.definition import Order
from bench.campaigns.planning.registry import build_sequence
from bench.protocols import Point

HEATING = "heating"
"""The sequence that brings the lubricant to a point's temperature."""


@dataclass(frozen=True, slots=True)
class Task:
    """One thing to do: a point of the campaign, or a heating for the point that follows it."""

    point: Point
    is_preparation: bool = False
    prepares: Point | None = None
    """The point a heating is for."""


def _none_left_out(point: Point) -> bool:
    return False


def schedule(
    points: Sequence[Point],
    order: Order,
    band: float,
    temperature: Callable[[], float],
    left_out: Callable[[Point], bool] = _none_left_out,
) -> Iterator[Task]:
    """Yield the tasks of one stage; ``temperature`` is asked anew before each, ``band`` is in K either side.

    ``left_out`` is asked right before a point's turn, and again after what was done to prepare it.

    With ascending temperatures, points measured as found go first; one with a temperature goes before them as soon
    as the lubricant has warmed up to it by itself: a bench that cannot cool would never see that temperature again.
    """
    remaining = list(points)
    if order is Order.TEMPERATURE:
        remaining.sort(key=lambda point: -float("inf") if point.temperature is None else point.temperature)
    while remaining:
        point = remaining.pop(_next(remaining, temperature()) if order is Order.TEMPERATURE else 0)
        if left_out(point):
            continue
        target = point.temperature
        prepares = build_sequence(point.sequence, point.options).prepares_temperature
        if prepares and target is not None and temperature() < target - band:
            yield Task(Point(HEATING, temperature=target, stage=point.stage), is_preparation=True, prepares=point)
            if left_out(point):
                continue
        yield Task(point)


def _next(remaining: Sequence[Point], temperature: float) -> int:
    if remaining[0].temperature is not None:
        return 0
    for index, point in enumerate(remaining):
        if point.temperature is not None:
            return index if point.temperature <= temperature else 0
    return 0
