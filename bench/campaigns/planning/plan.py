"""The plan of a campaign on a bench: each point with its time, warmth and energy; refused if it would break a limit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from bench.campaigns.planning.definition import Campaign
from bench.campaigns.planning.estimate import Estimator, TemperatureUnreachable, ThermalState
from bench.campaigns.planning.facts import facts
from bench.campaigns.planning.limit_check import check_demand, check_temperature
from bench.campaigns.planning.registry import build_sequence
from bench.campaigns.planning.schedule import HEATING, Task, schedule
from bench.campaigns.planning.soundness import check_phases
from bench.campaigns.tare import TARE
from bench.configuration import BenchConfiguration
from bench.errors import ConfigurationError, LimitError
from bench.protocols import Point


@dataclass(frozen=True, slots=True)
class PlannedTask:
    """One line of a plan. Times in s since the campaign begins, temperatures in °C, energy in J."""

    number: int
    """Of the point, from 1; 0 for what prepares one (a heating, the tare)."""
    point: Point
    is_preparation: bool
    start_s: float
    duration_s: float
    start_temperature: float
    end_temperature: float
    energy_j: float
    motor_torque: float
    """Greatest expected motor torque, N·m."""

    def as_dict(self) -> dict[str, Any]:
        """For ``--json``."""
        return {
            "number": self.number,
            "sequence": self.point.sequence,
            "stage": self.point.stage,
            "preparation": self.is_preparation,
            "load_torque_nm": self.point.load_torque,
            "velocity_rad_s": self.point.velocity,
            "temperature_degc": self.point.temperature,
            "repeat": self.point.repeat,
            "options": dict(self.point.options),
            "start_s": self.start_s,
            "duration_s": self.duration_s,
            "expected_start_temperature_degc": self.start_temperature,
            "expected_end_temperature_degc": self.end_temperature,
            "energy_j": self.energy_j,
            "expected_motor_torque_nm": self.motor_torque,
        }


@dataclass(frozen=True, slots=True)
class Plan:
    """All lines, and what they add up to."""

    campaign: str
    bench: str
    start_temperature: float
    tasks: tuple[PlannedTask, ...]

    @property
    def duration_s(self) -> float:
        """Bench time of the whole campaign."""
        return sum(task.duration_s for task in self.tasks)

    @property
    def heating_s(self) -> float:
        """Bench time spent bringing the lubricant to temperature."""
        return sum(task.duration_s for task in self._heatings())

    @property
    def heatings(self) -> int:
        """Number of heatings."""
        return len(self._heatings())

    def _heatings(self) -> list[PlannedTask]:
        return [task for task in self.tasks if task.is_preparation and task.point.sequence == HEATING]

    @property
    def energy_j(self) -> float:
        """Energy drawn."""
        return sum(task.energy_j for task in self.tasks)

    @property
    def points(self) -> int:
        """Number of points, heating not counted."""
        return sum(not task.is_preparation for task in self.tasks)

    def as_dict(self) -> dict[str, Any]:
        """For ``--json`` and ``campaign.json``."""
        return {
            "campaign": self.campaign,
            "bench": self.bench,
            "start_temperature_degc": self.start_temperature,
            "points": self.points,
            "duration_s": self.duration_s,
            "heating_s": self.heating_s,
            "energy_j": self.energy_j,
            "tasks": [task.as_dict() for task in self.tasks],
        }


def make_plan(campaign: Campaign, bench: BenchConfiguration, start_temperature: float | None = None) -> Plan:
    """Plan a campaign; ``start_temperature`` in °C defaults to the surroundings.

    Raises
    ------
    LimitError
        If any point would break a limit of the bench, or step; names the point and the limit.
    ConfigurationError
        If the campaign itself is wrong.
    """
    start = bench.nominal.ambient_temperature if start_temperature is None else start_temperature
    estimator, bench_facts = Estimator(bench), facts(bench)
    state, tasks = ThermalState(start), list[PlannedTask]()

    def temperature() -> float:
        return state.temperature

    def everything() -> Iterator[Task]:
        yield Task(TARE, is_preparation=True)
        for stage, points in zip(campaign.stages, campaign.points(start), strict=True):
            yield from schedule(points, stage.order, bench.heating.band, temperature)
        yield Task(TARE, is_preparation=True)

    count = 0
    for task in everything():
        point = task.point
        count += not task.is_preparation
        before = " before" if task.is_preparation else ""
        where = f"{campaign.name},{before} point {count + task.is_preparation} ({point.label})"
        check_temperature(point, bench, where)
        try:
            phases = check_phases(
                build_sequence(point.sequence, point.options).phases(point, bench_facts), bench, where
            )
            after, demand = estimator.run(phases, state)
        except ValueError as error:
            raise ConfigurationError(f"{where}: {error}") from error
        except TemperatureUnreachable as error:
            raise LimitError(
                f"{where}: {error} after the time limit of"
                f" {error.phase.duration_s / 60.0:.0f} min; choose another temperature or a longer limit"
            ) from error
        check_demand(demand, bench, where)
        tasks.append(
            PlannedTask(
                0 if task.is_preparation else count,
                point,
                task.is_preparation,
                state.time_s,
                after.time_s - state.time_s,
                state.temperature,
                after.temperature,
                after.energy_j - state.energy_j,
                demand.motor_torque,
            )
        )
        state = after
    return Plan(campaign.name, bench.name, start, tuple(tasks))
