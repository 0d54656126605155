"""The time of a recording: seconds since its first sample, and the moment of that, from what stamps a file has."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import ConfigurationError, RecordingError
from bench.importing.channel import Channel, read_channel, read_values
from bench.importing.channel_mapping import ChannelMapping
from bench.importing.files import Files
from bench.recording.header import ChannelSpec

_NANOSECOND = 1e-9
_POSIX = (4e8, 5e9)
"""Seconds since 1970 that are taken for a date: 1982 to 2128."""


@dataclass(frozen=True, slots=True)
class Clock:
    """Time stamps (N,) as a channel; ``started_at`` where they say it; ``notes`` what was taken for granted."""

    channel: Channel
    started_at: datetime | None = None
    notes: tuple[str, ...] = ()


def read_clock(wanted: ChannelMapping, files: Files, where: str, size: int) -> Clock:
    """Read the common time base; ``size`` is the length of the other channels, for a time that stands nowhere.

    Raises
    ------
    ConfigurationError, RecordingError
        The mapping or the file is wrong.
    """
    if wanted.value is not None:
        raise ConfigurationError(
            f"{where}.value: a time that is the same throughout is none, variable, column or rate would be right."
        )
    source = files.source(wanted.file)
    if not wanted.placed and not wanted.sum:
        assert wanted.rate is not None
        origin = f"{files.main.name}: {wanted.rate:g} Hz"
        spec = ChannelSpec.of("time", dtype="int64", scale=1 / wanted.rate, origin=origin)
        return Clock(Channel(np.arange(size, dtype=np.int64), spec, source), source.started_at)
    if not wanted.sum:
        stamps = read_values(source, wanted, where)
        if stamps.dtype.kind == "M":
            return _dated(stamps, wanted, files, where)
    if wanted.timezone is not None:
        raise ConfigurationError(
            f"{where}.timezone: is for dates, and '{wanted.variable}' holds numbers; leave it out."
        )
    channel = read_channel("time", wanted, files, where, linear=False)
    first = float(channel.si[0]) if channel.raw.size else 0.0
    if _POSIX[0] < first < _POSIX[1]:
        note = "time counts from 1970 (POSIX), started_at is its first stamp"
        return Clock(_from_first(channel), datetime.fromtimestamp(first, UTC), (note,))
    return Clock(channel, source.started_at)


def _from_first(channel: Channel) -> Channel:
    """Count from the first stamp, before a float loses what a large number costs."""
    raw = channel.raw - channel.raw[0]
    return replace(channel, raw=raw, spec=replace(channel.spec, dtype=str(raw.dtype), offset=0.0))


def _dated(stamps: NDArray[Any], wanted: ChannelMapping, files: Files, where: str) -> Clock:
    source = files.source(wanted.file)
    zoned = next((v.zoned for v in source.variables() if v.name == wanted.variable), False)
    if np.isnat(stamps).any():
        index = int(np.argmax(np.isnat(stamps)))
        raise RecordingError(
            f"{files.main}: time is missing in {source.location(index)}, every sample should have a stamp."
        )
    notes: tuple[str, ...] = ()
    if zoned and wanted.timezone is not None:
        raise ConfigurationError(f"{where}.timezone: the stamps say their zone themselves; leave it out.")
    if not zoned and wanted.timezone is None:
        notes = ("time stamps say no time zone and were taken for UTC; channels.time.timezone would say which it is",)
    if wanted.timezone is not None:
        stamps = _localised(stamps, wanted.timezone, files, where)
    nanoseconds = stamps.astype("datetime64[ns]").astype(np.int64)
    raw = nanoseconds - nanoseconds[0]
    origin = f"{files.path(wanted.file).name}/{wanted.variable or f'column {wanted.column}'}"
    spec = ChannelSpec.of("time", dtype="int64", scale=_NANOSECOND, origin=origin)
    started = datetime.fromtimestamp(int(nanoseconds[0]) / 1e9, UTC)
    return Clock(Channel(raw, spec, source), started, notes)


def _localised(stamps: NDArray[Any], zone: str, files: Files, where: str) -> NDArray[Any]:
    """Local time as UTC; the hour that comes twice in autumn is recognised by the order of the stamps."""
    from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

    import pandas

    try:
        known = ZoneInfo(zone)
    except (ZoneInfoNotFoundError, ValueError, OSError):
        raise ConfigurationError(
            f"{where}.timezone: '{zone}' is no time zone, one such as 'UTC' or 'Europe/Berlin' would be right."
        ) from None
    local = pandas.DatetimeIndex(stamps)
    try:
        aware = local.tz_localize(known, ambiguous="infer", nonexistent="raise")
    except ValueError as error:
        if "ambiguous" in str(error).lower() or "repeated" in str(error).lower():
            first = local[0].tz_localize(known, ambiguous=True)
            return np.asarray((first + (local - local[0])).tz_convert(None).to_numpy())
        why = str(error).splitlines()[0].split(" due to")[0]
        raise RecordingError(
            f"{files.main}: time stamps do not exist in {zone} ({why}, where summer time begins); "
            "channels.time.timezone should be the zone they were written in."
        ) from error
    return np.asarray(aware.tz_convert(None).to_numpy())
