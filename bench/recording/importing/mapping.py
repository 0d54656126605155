"""The mapping file: TOML, checked; unknown keys are refused."""

from __future__ import annotations

import tomllib
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from bench.errors import ConfigurationError
from bench.recording.header import KINDS, SEGMENT_NAMES


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class ChannelMapping(_Strict):
    """One channel: where it stands in the file, in which unit, and how a raw value becomes one in that unit.

    Value in ``unit`` = raw · ``scale`` + ``offset``. ``scale`` and ``offset`` are numbers, or names of variables of the
    same file that hold one number.
    """

    variable: str | None = None
    """Name in the file: ``qm``, ``data.qm`` (MAT structure), ``group/qm`` (HDF5, TDMS) or a CSV heading."""
    column: int | None = Field(default=None, ge=1)
    """Column of a matrix variable, or of a CSV file without headings; counted from 1."""
    unit: str = "1"
    scale: float | str = 1.0
    offset: float | str = 0.0
    wraps_at: float | None = Field(default=None, gt=0)
    """Raw counts (or angle, in raw units) after which the value starts again; it is unwrapped."""
    rate: float | None = Field(default=None, gt=0)
    """Only for ``time`` that stands in no variable: samples per second."""
    description: str = ""

    @model_validator(mode="after")
    def _has_a_place(self) -> ChannelMapping:
        if self.variable is None and self.column is None and self.rate is None:
            raise ValueError("needs 'variable' or 'column' (or, for time, 'rate')")
        return self


class SegmentMapping(_Strict):
    """A segment in samples or in seconds; without bounds it is the whole recording."""

    name: str
    start: int | None = Field(default=None, ge=0)
    stop: int | None = Field(default=None, ge=0)
    start_s: float | None = None
    stop_s: float | None = None

    @field_validator("name")
    @classmethod
    def _known(cls, name: str) -> str:
        if name not in SEGMENT_NAMES:
            raise ValueError(f"should be one of {', '.join(SEGMENT_NAMES)}")
        return name

    @model_validator(mode="after")
    def _one_way(self) -> SegmentMapping:
        if (self.start is not None and self.start_s is not None) or (self.stop is not None and self.stop_s is not None):
            raise ValueError("is given in samples and in seconds, one of them is enough")
        return self


class SetpointMapping(_Strict):
    """What was commanded: ``load_torque`` N·m, ``velocity`` rad/s at the load side, ``temperature`` °C."""

    load_torque: float = float("nan")
    velocity: float = float("nan")
    temperature: float = float("nan")


class GearboxMapping(_Strict):
    """Ratio and, where the gearbox has them, tooth numbers."""

    ratio: float
    z1: int | None = None
    z2: int | None = None
    z3: int | None = None
    z4: int | None = None

    @field_validator("ratio")
    @classmethod
    def _not_zero(cls, ratio: float) -> float:
        if ratio == 0:
            raise ValueError("should not be 0")
        return ratio


class CsvMapping(_Strict):
    """How CSV files are written; what is left out is found from the file."""

    delimiter: str | None = None
    decimal: Literal[".", ","] = "."
    comment: str = "#"
    skip_lines: int = Field(default=0, ge=0)
    """Lines before the headings (or before the data, where there are none)."""


class RecordingMapping(_Strict):
    """One recording, or with a pattern such as ``run_*.csv`` one for each file that fits."""

    file: str
    recording_id: str | None = None
    kind: str | None = None
    started_at: datetime | None = None
    setpoint: SetpointMapping = SetpointMapping()
    segments: tuple[SegmentMapping, ...] | None = None
    channels: dict[str, ChannelMapping] = {}
    """Channels that differ from the common ones."""


class Mapping(_Strict):
    """A whole mapping file; what stands at the top holds for every recording that does not say otherwise."""

    campaign_id: str
    kind: str = "free"
    sample_rate: float | None = Field(default=None, gt=0)
    """Hz; found from ``time`` where it is left out."""
    started_at: datetime | None = None
    invalid_rows: Literal["refuse", "drop"] = "refuse"
    """What to do with rows that hold NaN or whose time does not increase."""
    gearbox: GearboxMapping
    gearbox_serial: str | None = None
    zero_id: str | None = None
    csv: CsvMapping = CsvMapping()
    channels: dict[str, ChannelMapping]
    segments: tuple[SegmentMapping, ...] = ()
    recordings: Annotated[tuple[RecordingMapping, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _kinds_and_time(self) -> Mapping:
        for kind in (self.kind, *(r.kind for r in self.recordings if r.kind is not None)):
            if kind not in KINDS:
                raise ValueError(f"kind '{kind}' should be one of {', '.join(KINDS)}")
        for recording in self.recordings:
            names = self.channels.keys() | recording.channels.keys()
            if "time" not in names or len(names) < 2:
                raise ValueError("channels should hold 'time' and at least one measured channel")
        return self


def load_mapping(path: Path) -> tuple[Mapping, str]:
    """Read a mapping file; gives it and its text, which is kept in the recordings as provenance.

    Raises
    ------
    ConfigurationError
        The file is missing or not TOML, or a key is unknown, missing or wrong.
    """
    try:
        text = path.read_text(encoding="utf-8")
        return Mapping.model_validate(tomllib.loads(text)), text
    except FileNotFoundError:
        raise ConfigurationError(f"{path}: there is no such mapping file.") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ConfigurationError(f"{path}: is not a readable TOML file ({error}).") from error
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"]) or "the file"
        given = f" (given: {first['input']!r})" if not isinstance(first["input"], dict) else ""
        raise ConfigurationError(f"{path}: {key}: {first['msg']}{given}.") from error


def as_utc(moment: datetime) -> datetime:
    """Give an aware UTC time; one without zone is UTC."""
    return moment.replace(tzinfo=UTC) if moment.tzinfo is None else moment.astimezone(UTC)
