"""How a recording is laid out in HDF5; the one place that creates groups, datasets and attributes."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from datetime import UTC
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.recording.header import FORMAT, FORMAT_VERSION, ChannelSpec, Event, RecordingHeader, Segment

_TEXT = h5py.string_dtype()
_LONGEST_TEXT = 4000
_OPTIONAL_ATTRIBUTES = ("point_id", "take", "zero_id", "gearbox_serial", "axis")
# UDUNITS, which CF builds on, has no degree sign; ours are already written its way.
_CF_UNITS = {"°C": "degC", "N·m": "N m"}

_TABLES: dict[str, tuple[tuple[str, Any], ...]] = {
    "segments": (("name", _TEXT), ("start", np.dtype("int64")), ("stop", np.dtype("int64"))),
    "events": (("time", np.dtype("float64")), ("level", _TEXT), ("text", _TEXT)),
}


def check_channels(path: Path, channels: Sequence[ChannelSpec]) -> None:
    """Refuse channels that could not make a valid recording, before a file exists."""
    names = [channel.name for channel in channels]
    if len(set(names)) != len(names):
        raise RecordingError(f"{path}: a channel is listed twice in {', '.join(names)}.")
    if "time" not in names:
        raise RecordingError(f"{path}: the channels {', '.join(names)} lack 'time', the common time base.")
    for channel in channels:
        kind = np.dtype(channel.dtype)
        if kind.kind not in "iuf" or kind == np.dtype("float32") or kind == np.dtype("float16"):
            raise RecordingError(
                f"{path}: channel '{channel.name}' would be stored as {kind}; integers or float64 are allowed."
            )


def exact(path: Path, channel: ChannelSpec, values: NDArray[Any]) -> NDArray[Any]:
    """Convert values to the type of their channel, or refuse where a value would change."""
    dtype = np.dtype(channel.dtype)
    if values.dtype == dtype:
        return values
    with np.errstate(invalid="ignore"):
        converted = values.astype(dtype)
        if not np.array_equal(converted, values, equal_nan=dtype.kind == "f"):
            raise RecordingError(
                f"{path}: values of channel '{channel.name}' ({values.dtype}) do not fit {dtype} without change."
            )
    return converted


def write_skeleton(file: h5py.File, header: RecordingHeader, channels: Sequence[ChannelSpec], chunk_rows: int) -> None:
    """Create everything but the samples: attributes, empty channels with their dimension scale, empty tables."""
    _write_root(file, header)
    setpoint = file.create_group("setpoint")
    for entry in fields(header.setpoint):
        setpoint.attrs[entry.name] = float(getattr(header.setpoint, entry.name))
    gearbox = file.create_group("gearbox")
    for entry in fields(header.gearbox):
        value = getattr(header.gearbox, entry.name)
        if value is not None:
            gearbox.attrs[entry.name] = value
    group = file.create_group("channels")
    for channel in channels:
        _create_channel(group, channel, chunk_rows)
    time = group["time"]
    time.make_scale("time")
    for channel in channels:
        if channel.name != "time":
            group[channel.name].dims[0].attach_scale(time)
    for name, columns in _TABLES.items():
        table = file.create_group(name)
        for column, dtype in columns:
            table.create_dataset(column, shape=(0,), maxshape=(None,), dtype=dtype, chunks=(64,))
    if header.config is not None:
        file.create_dataset("config", data=header.config, dtype=_TEXT)
    software = file.create_group("software")
    for key, text in header.software.items():
        software.attrs[key] = text


def _write_root(file: h5py.File, header: RecordingHeader) -> None:
    if header.started_at.tzinfo is None:
        raise RecordingError(f"{file.filename}: started_at {header.started_at} has no time zone, it should be in UTC.")
    file.attrs["format"] = FORMAT
    file.attrs["format_version"] = FORMAT_VERSION
    for name in ("recording_id", "campaign_id", "kind", "source"):
        file.attrs[name] = getattr(header, name)
    file.attrs["started_at"] = header.started_at.astimezone(UTC).isoformat()
    file.attrs["sample_rate"] = float(header.sample_rate)
    for name in _OPTIONAL_ATTRIBUTES:
        value = getattr(header, name)
        if value is not None:
            file.attrs[name] = value
    for key, value in header.attributes.items():
        file.attrs[key] = value


def _create_channel(group: h5py.Group, channel: ChannelSpec, chunk_rows: int) -> None:
    dataset = group.create_dataset(
        channel.name,
        shape=(0,),
        maxshape=(None,),
        dtype=channel.dtype,
        chunks=(chunk_rows,),
        shuffle=True,
        compression="gzip",
        compression_opts=1,
    )
    attrs = dataset.attrs
    attrs["unit"] = channel.unit
    attrs["scale"] = float(channel.scale)
    attrs["offset"] = float(channel.offset)
    attrs["description"] = channel.description
    attrs["origin"] = channel.origin
    # The CF names of the same, for xarray. Both factors always, both float64: with one of them alone xarray would
    # decode 16-bit integers to float32.
    attrs["units"] = _CF_UNITS.get(channel.unit, channel.unit)
    attrs["long_name"] = channel.description
    if np.dtype(channel.dtype).kind != "f" or channel.scale != 1.0 or channel.offset != 0.0:
        attrs["scale_factor"] = float(channel.scale)
        attrs["add_offset"] = float(channel.offset)


def append_rows(file: h5py.File, table: str, rows: Sequence[Sequence[Any]]) -> None:
    """Append rows to ``segments`` or ``events``."""
    if not rows:
        return
    for (column, _), values in zip(_TABLES[table], zip(*rows, strict=True), strict=False):
        dataset = file[table][column]
        size = dataset.shape[0]
        dataset.resize((size + len(rows),))
        dataset[size:] = list(values)


def segment_rows(segments: Iterable[Segment]) -> list[tuple[str, int, int]]:
    """Turn segments into rows of their table."""
    return [(segment.name, segment.start, segment.stop) for segment in segments]


def event_rows(events: Iterable[Event]) -> list[tuple[float, str, str]]:
    """Turn events into rows of their table; their texts can always be written, whoever typed them."""
    return [(event.time, event.level, _writable(event.text)) for event in events]


def _writable(text: str) -> str:
    """Return a text as HDF5 can hold it: no NUL, no half of a surrogate pair, not longer than a page."""
    kept = text if len(text) <= _LONGEST_TEXT else f"{text[: _LONGEST_TEXT - 1]}…"
    return kept.replace("\0", "\ufffd").encode("utf-8", "replace").decode("utf-8")


def write_end(
    file: h5py.File, *, accepted: bool | None, quality: Mapping[str, Any] | None, complete: bool = True
) -> None:
    """Write what is known only at the end; ``complete`` as the very last."""
    if accepted is not None:
        file.attrs["accepted"] = np.bool_(accepted)
    if quality is not None:
        file.attrs["quality"] = json.dumps(quality)
    file.attrs["complete"] = np.bool_(complete)


def sync(path: Path) -> None:
    """Force a file or a folder to the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def finish(part: Path, path: Path) -> None:
    """Give a closed ``.part`` file its name, so that after a power cut it is either whole or not there."""
    sync(part)
    os.replace(part, path)
    sync(path.parent)
