"""Campaign files: TOML, or a Python file that defines ``campaign``."""

from __future__ import annotations

import runpy
import tomllib
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationError

from bench.campaigns.planning.definition import Block, Campaign, Order, Stage
from bench.campaigns.planning.registry import parse_options
from bench.campaigns.planning.soundness import MOST_REPEATS
from bench.configuration.loading import explain
from bench.configuration.parts import Section
from bench.configuration.quantities import Speed, Torque, parse_quantity
from bench.errors import BenchError, ConfigurationError

_SHIPPED = resources.files("bench.campaigns") / "library"


def _temperature(value: object) -> float | None:
    return None if value == "as found" else parse_quantity(value, "temperature")


class BlockSection(Section):
    """Points of one sequence."""

    sequence: str
    load_torques: Annotated[tuple[Torque, ...], Field(min_length=1)] = (0.0,)
    velocities: Annotated[tuple[Speed, ...], Field(min_length=1)] = (0.0,)
    temperatures: Annotated[tuple[Annotated[float | None, BeforeValidator(_temperature)], ...], Field(min_length=1)] = (
        None,
    )
    repeats: Annotated[int, Field(ge=1, le=MOST_REPEATS)] = 1
    options: dict[str, Any] = Field(default_factory=dict)


class StageSection(Section):
    """Blocks that are planned together."""

    name: str
    order: Order = Order.TEMPERATURE
    points: Annotated[tuple[BlockSection, ...], Field(min_length=1)]


class CampaignFile(Section):
    """The whole file."""

    format: Literal["bench-campaign"]
    format_version: Literal["1.0"]
    name: str
    title: str
    stages: Annotated[tuple[StageSection, ...], Field(min_length=1)]


def shipped_campaigns() -> tuple[str, ...]:
    """Names of the campaigns that come with the program."""
    names = (entry.name for entry in _SHIPPED.iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))


def load_campaign(name_or_path: str | Path) -> Campaign:
    """Load a campaign by the name of a shipped one, or from a TOML or a Python file.

    Raises
    ------
    ConfigurationError
        In one sentence: file, key, value, reason, and what would be right.
    """
    name = str(name_or_path)
    if name in shipped_campaigns():
        return parse_campaign((_SHIPPED / f"{name}.toml").read_text("utf-8"), f"{name}.toml")
    path = Path(name)
    if path.suffix == ".py":
        return _from_python(path)
    if not path.exists():
        shipped = ", ".join(shipped_campaigns())
        raise ConfigurationError(f'there is no campaign "{name}"; name one of {shipped} or the path of a file')
    try:
        text = path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise ConfigurationError(f"campaign file {path} cannot be read: {why}") from error
    return parse_campaign(text, str(path))


def parse_campaign(text: str, origin: str) -> Campaign:
    """Parse the TOML text of a campaign (see :func:`load_campaign`)."""
    try:
        file = CampaignFile.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise ConfigurationError(f"{origin} is not valid TOML: {error}") from error
    except ValidationError as error:
        raise ConfigurationError(explain(error, origin)) from error
    try:
        stages = tuple(
            Stage(stage.name, tuple(_block(block) for block in stage.points), stage.order) for stage in file.stages
        )
        return Campaign(file.name, file.title, stages, text)
    except BenchError as error:
        raise ConfigurationError(f"{origin}: {error}") from error


def _block(section: BlockSection) -> Block:
    return Block(
        section.sequence,
        section.load_torques,
        section.velocities,
        section.temperatures,
        section.repeats,
        parse_options(section.sequence, section.options),
    )


def _from_python(path: Path) -> Campaign:
    if not path.exists():
        raise ConfigurationError(f"there is no campaign file {path}")
    campaign = runpy.run_path(str(path)).get("campaign")
    if not isinstance(campaign, Campaign):
        raise ConfigurationError(f"{path} must define a variable campaign of type bench.campaigns.Campaign")
    return campaign
