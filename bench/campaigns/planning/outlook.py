"""What is still to come: the time a run still takes, and the lubricant's expected way to the next temperature."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bench.campaigns.planning.estimate import Estimator, TemperatureUnreachable, ThermalState
from bench.campaigns.planning.plan import Plan
from bench.configuration import BenchConfiguration
from bench.protocols import Phase, Point

_STEP_S = 20.0


def costs(plan: Plan) -> dict[Point, float]:
    """Return the planned bench time of each point in s, with what prepares it."""
    out: dict[Point, float] = {}
    before = 0.0
    for task in plan.tasks:
        if task.is_preparation:
            before += task.duration_s
        else:
            out[task.point] = before + task.duration_s
            before = 0.0
    return out


def planned_way(plan: Plan) -> list[tuple[float, float]]:
    """Return the planned temperature: (time in s since the campaign began, °C) at the ends of every task."""
    way = [(0.0, plan.start_temperature)]
    for task in plan.tasks:
        way.append((task.start_s + task.duration_s, task.end_temperature))
    return way


def expected_way(
    phases: Sequence[Phase], bench: BenchConfiguration, temperature: float
) -> tuple[list[tuple[float, float]], bool]:
    """Return (time in s from now, °C) while ``phases`` run from ``temperature``, and whether it gets where it should.

    Phases are cut into pieces of 20 s; one with a condition ends where the condition is met.
    """
    estimator, state = Estimator(bench), ThermalState(temperature)
    way = [(0.0, temperature)]
    for phase in phases:
        if phase.until is None:
            state, _ = estimator.run((phase,), state)
            way.append((state.time_s, state.temperature))
            continue
        # for the estimator a motion starts at rest: a leading phase of no duration brings it to speed
        at_speed, remaining, met = replace(phase, duration_s=0.0, until=None), phase.duration_s, False
        while remaining > 0.0 and not met:
            piece = replace(phase, duration_s=min(_STEP_S, remaining))
            try:
                state, _ = estimator.run((at_speed, piece), state)
                met = True
            except TemperatureUnreachable:
                state, _ = estimator.run((at_speed, replace(piece, until=None)), state)
            remaining -= piece.duration_s
            way.append((state.time_s, state.temperature))
        if not met:
            return way, False
    return way, True
