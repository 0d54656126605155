"""The mapping file: TOML, checked; unknown keys are refused, and so is what still says ``?``."""

from __future__ import annotations

import re
import tomllib
from datetime import UTC, datetime
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, ValidationError, field_validator, model_validator

from bench.errors import ConfigurationError
from bench.importing.channel_mapping import NO_PLACE, ChannelMapping, Strict
from bench.importing.formats.text_layout import TextOptions
from bench.recording.header import KINDS, SEGMENT_NAMES
from bench.signals import BY_NAME

OPEN = "?"
"""What a mapping says where its reader has to decide."""
_AUX_NAME = re.compile(r"[A-Za-z0-9_.\-]+")
_DECIDE = {
    "ratio": "revolutions of the motor per revolution of the output; 1 for a direct drive or a linear axis",
    "axis": "'rotary' or 'linear'",
    "unit": "a unit such as 'deg', 'rpm', 'N*m', 'A'",
    "torque_constant": "a number in N·m/A (on a linear axis N/A)",
    "factor": "a number with a unit, such as '3.2 N*m' for 100 % or '0.3 m' for a lever",
    "counts_per_revolution": "the encoder's counts per revolution of its shaft",
    "rate": "samples per second",
    "timezone": "a zone such as 'UTC' or 'Europe/Berlin'",
    "variable": "a variable of the file",
}


class SegmentMapping(Strict):
    """A segment in samples or in seconds of the file; without bounds it is the whole recording."""

    name: str
    start: int | None = Field(default=None, ge=0)
    stop: int | None = Field(default=None, ge=0)
    start_s: float | None = None
    stop_s: float | None = None

    @field_validator("name")
    @classmethod
    def _check_name(cls, name: str) -> str:
        if name not in SEGMENT_NAMES:
            raise ValueError(f"should be one of {', '.join(SEGMENT_NAMES)}")
        return name

    @model_validator(mode="after")
    def _one_way(self) -> SegmentMapping:
        _one_way(self.start, self.start_s, self.stop, self.stop_s)
        return self


def _one_way(start: int | None, start_s: float | None, stop: int | None, stop_s: float | None) -> None:
    if (start is not None and start_s is not None) or (stop is not None and stop_s is not None):
        raise ValueError("is given in samples and in seconds, one of them is enough")


class PiecesMapping(Strict):
    """Pieces of a long recording: of ``revolutions`` of the output, or of ``seconds``; every sample in one of them.

    Where fewer than ``at_least`` would come of all files together they are made shorter, and the recordings say so.
    """

    revolutions: float | None = Field(default=None, gt=0)
    seconds: float | None = Field(default=None, gt=0)
    at_least: int = Field(default=6, ge=1)

    @model_validator(mode="after")
    def _one_length(self) -> PiecesMapping:
        if (self.revolutions is None) == (self.seconds is None):
            raise ValueError("should have either 'revolutions' or 'seconds'")
        return self


class SetpointMapping(Strict):
    """What was commanded: ``load_torque`` N·m, ``velocity`` rad/s at the load side, ``temperature`` °C."""

    load_torque: float = float("nan")
    velocity: float = float("nan")
    temperature: float = float("nan")


class GearboxMapping(Strict):
    """Ratio and, where the gearbox has them, tooth numbers. ``axis`` is found from the units where it is left out."""

    ratio: float
    axis: Literal["rotary", "linear"] | None = None
    z1: int | None = None
    z2: int | None = None
    z3: int | None = None
    z4: int | None = None

    @model_validator(mode="after")
    def _possible(self) -> GearboxMapping:
        if self.ratio == 0:
            raise ValueError("ratio should not be 0")
        if self.axis == "linear" and self.ratio != 1.0:
            raise ValueError("ratio should be 1 on a linear axis; 'factor' of a channel makes metres of revolutions")
        return self


class CsvMapping(Strict):
    """How text files are written; what is left out is found from the file."""

    delimiter: str | None = None
    """One mark; a space is any white space."""
    decimal: Literal[".", ","] | None = None
    comment: str = "#"
    skip_lines: int = Field(default=0, ge=0)
    """Lines at the beginning that are passed over."""
    data_in: Literal["columns", "rows"] | None = None
    encoding: str | None = None

    def options(self) -> TextOptions:
        """As the reader of text files takes it."""
        return TextOptions(self.delimiter, self.decimal, self.comment, self.skip_lines, self.data_in, self.encoding)


class RecordingMapping(Strict):
    """One recording, or with a pattern such as ``run_*.csv`` one for each file that fits.

    ``start``, ``stop`` (samples) or ``start_s``, ``stop_s`` (seconds since the file's first sample) cut it out.
    """

    file: str
    recording_id: str | None = None
    kind: str | None = None
    started_at: datetime | None = None
    start: int | None = Field(default=None, ge=0)
    stop: int | None = Field(default=None, ge=0)
    start_s: float | None = None
    stop_s: float | None = None
    pieces: PiecesMapping | None = None
    setpoint: SetpointMapping = SetpointMapping()
    segments: tuple[SegmentMapping, ...] | None = None
    channels: dict[str, ChannelMapping] = Field(default={})
    """Channels that differ from the common ones."""

    @model_validator(mode="after")
    def _cut_one_way(self) -> RecordingMapping:
        _one_way(self.start, self.start_s, self.stop, self.stop_s)
        return self


class Mapping(Strict):
    """A whole mapping file; what stands at the top holds for every recording that does not say otherwise."""

    campaign_id: str
    kind: str = "free"
    sample_rate: float | None = Field(default=None, gt=0)
    """Hz; found from ``time`` where it is left out."""
    started_at: datetime | None = None
    invalid_rows: Literal["refuse", "drop"] = "refuse"
    """What to do with rows that hold NaN or whose time does not increase."""
    irregular: Literal["resample", "refuse", "keep"] = "resample"
    """What to do with time stamps whose steps differ."""
    repeated: Literal["leave_out", "keep"] = "leave_out"
    """What to do with rows that only repeat what the drives said before: a log quicker than its drives."""
    gaps: Literal["refuse", "cut", "keep"] = "refuse"
    """What to do where nothing was recorded for a while."""
    pieces: PiecesMapping | None = None
    gearbox: GearboxMapping
    gearbox_serial: str | None = None
    zero_id: str | None = None
    csv: CsvMapping = CsvMapping()
    channels: dict[str, ChannelMapping]
    aux: dict[str, ChannelMapping] = Field(default={})
    """Measured quantities that are no channel of the bench, kept as ``aux/NAME``."""
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
                alone = "; [aux.NAME] alone is none" if self.aux else ""
                raise ValueError(f"channels should hold 'time' and at least one measured channel{alone}")
        for name in self.aux:
            if not _AUX_NAME.fullmatch(name):
                raise ValueError(f"aux.{name} should have a name of letters, digits and _ . - only")
        for name in (*self.channels, *(name for r in self.recordings for name in r.channels)):
            if "/" in name:
                raise ValueError(f"channels.{name} should have a name without '/'; [aux.NAME] is the table of others")
        return self

    @property
    def columns(self) -> dict[str, ChannelMapping]:
        """All channels by the name they get, auxiliary ones among them."""
        return {**self.channels, **{f"aux/{name}": wanted for name, wanted in self.aux.items()}}


def load_mapping(path: Path, changes: dict[str, Any] | None = None) -> tuple[Mapping, str]:
    """Read a mapping file; gives it and its text, which is kept in the recordings as provenance.

    ``changes`` by key, such as ``gearbox.ratio``, come before what the file says.

    Raises
    ------
    ConfigurationError
        The file is missing or not TOML, or a key is unknown, missing, wrong or still open.
    """
    try:
        text = path.read_text(encoding="utf-8")
        content = tomllib.loads(text)
    except FileNotFoundError:
        raise ConfigurationError(f"{path}: there is no such mapping file.") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        other = path.suffix.lower() != ".toml"
        right = f"; 'bench import --look {path.name}' writes a mapping of a file of measurements" if other else ""
        raise ConfigurationError(f"{path}: is not a readable TOML file ({error}){right}.") from error
    for key, value in (changes or {}).items():
        set_value(content, key, value, f"{path}")
    refuse_open(content, path)
    try:
        mapping = Mapping.model_validate(content)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"]) or "the file"
        given = f" (given: {first['input']!r})" if not isinstance(first["input"], dict | BaseModel) else ""
        said = first["msg"].removeprefix("Value error, ")
        problem = f"is no key there; {_keys(key)}" if first["type"] == "extra_forbidden" else f"{said}{given}."
        problem += _suggestion(key, content) if first["type"] == NO_PLACE else ""
        raise ConfigurationError(f"{path}: {key}{' ' if problem.startswith('is') else ': '}{problem}") from error
    changed = "".join(f"# changed on the command line: {key} = {value!r}\n" for key, value in (changes or {}).items())
    return mapping, changed + text


def _suggestion(key: str, content: dict[str, Any]) -> str:
    """A table of almost the same name as one of channels that is nowhere and whose name the bench does not know."""
    table, _, name = key.partition(".")
    if name in BY_NAME:
        return ""
    others = [other for other in content.get(table, ()) if other != name] if table in ("channels", "aux") else []
    near = get_close_matches(name, others, n=1)
    return f" Did you mean '{table}.{near[0]}'?" if near else ""


def _keys(key: str) -> str:
    """What stands in a table of which somebody wrote an unknown key."""
    *tables, last = (part for part in key.split(".") if not part.isdigit())
    table: type[BaseModel] = _TABLES.get(tables[0] if tables else "", Mapping)
    table = ChannelMapping if set(tables) & {"channels", "aux", "sum"} else table
    near = get_close_matches(last, table.model_fields, n=1)
    meant = f"; did you mean '{near[0]}'?" if near else "."
    return f"keys are {', '.join(table.model_fields)}{meant}"


_TABLES: dict[str, type[BaseModel]] = {
    "gearbox": GearboxMapping,
    "csv": CsvMapping,
    "recordings": RecordingMapping,
    "segments": SegmentMapping,
    "pieces": PiecesMapping,
}


def set_value(content: dict[str, Any], key: str, value: Any, where: str) -> None:
    """Set a key such as ``channels.motor_torque.unit`` in a tree of tables.

    Raises
    ------
    ConfigurationError
        A part of the key is no table.
    """
    *folders, last = key.split(".")
    inner: Any = content
    for part in folders:
        inner = inner.setdefault(part, {}) if isinstance(inner, dict) else None
    if not isinstance(inner, dict):
        raise ConfigurationError(f"{where}: {key} lies in no table, it should be a key such as gearbox.ratio.")
    inner[last] = value


def refuse_open(content: Any, path: Path, key: str = "") -> None:
    """Refuse a mapping in which something is still open.

    Raises
    ------
    ConfigurationError
        A value is ``?``; the sentence says what it should be.
    """
    if isinstance(content, dict):
        for name, value in content.items():
            refuse_open(value, path, f"{key}.{name}" if key else name)
    elif isinstance(content, list):
        for index, value in enumerate(content):
            refuse_open(value, path, f"{key}.{index}")
    elif content == OPEN:
        meant = _DECIDE.get(key.rpartition(".")[2], "a value")
        raise ConfigurationError(f"{path}: {key} is still '?', it should be {meant}.")


def as_utc(moment: datetime) -> datetime:
    """Give an aware UTC time; one without zone is UTC."""
    return moment.replace(tzinfo=UTC) if moment.tzinfo is None else moment.astimezone(UTC)
