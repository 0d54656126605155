"""A campaign as plain Python: stages of blocks of points. A campaign file is the same thing written as TOML."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from bench.campaigns.planning.registry import build_sequence
from bench.campaigns.planning.soundness import check_block, check_points
from bench.errors import ConfigurationError
from bench.names import require_name
from bench.protocols import Point, Request


class Order(Enum):
    """In which order the points of a stage are visited."""

    TEMPERATURE = "temperature"
    """Ascending temperature, blocks merged; points as found while the lubricant is still below the next one."""
    LISTED = "listed"
    """As they stand."""


@dataclass(frozen=True, slots=True)
class Block:
    """Points of one sequence. Values in SI (load side, °C); None as a temperature means as found."""

    sequence: str
    load_torques: tuple[float, ...] = (0.0,)
    velocities: tuple[float, ...] = (0.0,)
    temperatures: tuple[float | None, ...] = (None,)
    repeats: int = 1
    options: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Stage:
    """Blocks that are planned together; the next stage begins when all its points are done."""

    name: str
    blocks: tuple[Block, ...]
    order: Order = Order.TEMPERATURE


@dataclass(frozen=True, slots=True)
class Campaign:
    """What is to be measured, independent of the bench that does it."""

    name: str
    title: str
    stages: tuple[Stage, ...]
    text: str = field(default="", repr=False)
    """The file it was read from, for provenance; empty for a campaign made in Python."""

    def __post_init__(self) -> None:
        """Refuse a name that could not be one of a folder (ConfigurationError)."""
        require_name(self.name, "the campaign name")

    def points(self, start_temperature: float) -> tuple[tuple[Point, ...], ...]:
        """Return the points of each stage, given the lubricant's temperature in °C when the campaign begins.

        Raises
        ------
        ConfigurationError
            If a sequence is unknown, an option wrong or out of bounds, a value no number, or two points are the same.
        """
        return tuple(tuple(_stage_points(stage, start_temperature)) for stage in self.stages)


def _stage_points(stage: Stage, start_temperature: float) -> list[Point]:
    points: list[Point] = []
    for block in stage.blocks:
        where = f'stage "{stage.name}", {block.sequence}'
        check_block(block, where)
        request = Request(
            block.sequence,
            block.load_torques,
            block.velocities,
            block.temperatures,
            block.repeats,
            stage.name,
            start_temperature,
            block.options,
        )
        try:
            points.extend(build_sequence(block.sequence, block.options).points(request))
        except ValueError as error:
            raise ConfigurationError(f"{where}: {error}") from error
        check_points(points, where)
    if len(set(points)) != len(points):
        twice = next(point for point in points if points.count(point) > 1)
        raise ConfigurationError(f'stage "{stage.name}" has the point "{twice.label}" twice; use repeats instead')
    return points
