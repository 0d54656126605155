"""Files of other tools become recordings, as a mapping file says."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import ConfigurationError, RecordingError
from bench.recording.folder import Rejected
from bench.recording.header import ChannelSpec, Event, Gearbox, RecordingHeader, Segment, Setpoint
from bench.recording.importing.mapping import (
    ChannelMapping,
    Mapping,
    RecordingMapping,
    SegmentMapping,
    as_utc,
    load_mapping,
)
from bench.recording.importing.sources import Source, open_source
from bench.recording.importing.units import unit_of
from bench.recording.missing import consequences
from bench.recording.one_shot import write_recording
from bench.recording.reader import Recording
from bench.signals import BY_NAME

_LINEAR = {"m": "rad", "m/s": "rad/s", "N": "N·m"}
"""On a linear axis (ratio 1) these stand for the rotary units of the channel table."""


@dataclass(frozen=True, slots=True)
class Imported:
    """A recording made from ``source``, with what its missing channels rule out, one sentence each."""

    source: Path
    recording: Recording
    consequences: tuple[str, ...]


def import_recordings(
    mapping_path: str | Path, out: str | Path, data: str | Path | None = None
) -> Iterator[Imported | Rejected]:
    """Import all files of a mapping, one after another, into the folder ``out``; a file that is no use stops no other.

    Parameters
    ----------
    data : folder in which the files are sought; by default the mapping file's own.

    Raises
    ------
    ConfigurationError
        The mapping file is wrong.
    """
    mapping_path, out = Path(mapping_path), Path(out)
    mapping, text = load_mapping(mapping_path)
    folder = Path(data) if data is not None else mapping_path.parent
    out.mkdir(parents=True, exist_ok=True)
    for entry in mapping.recordings:
        for file in _files(folder, entry):
            target = out / f"{entry.recording_id or file.stem}.h5"
            try:
                _import_one(mapping, text, mapping_path, entry, file, target)
            except RecordingError as error:
                yield Rejected(file, str(error))
                continue
            recording = Recording.open(target)
            yield Imported(file, recording, consequences(recording))


def _files(folder: Path, entry: RecordingMapping) -> list[Path]:
    files = sorted(folder.glob(entry.file)) if any(mark in entry.file for mark in "*?[") else [folder / entry.file]
    if not files:
        raise ConfigurationError(f"{folder / entry.file}: no file fits this pattern of recordings.file.")
    if len(files) > 1 and entry.recording_id is not None:
        raise ConfigurationError(
            f"recordings.recording_id '{entry.recording_id}' would name {len(files)} files of the pattern "
            f"'{entry.file}'; leave it out, each then has the name of its file."
        )
    return files


def _import_one(
    mapping: Mapping, text: str, mapping_path: Path, entry: RecordingMapping, file: Path, target: Path
) -> None:
    if target.exists():
        raise RecordingError(f"{target}: is there already, an import does not overwrite recordings.")
    source = open_source(file, mapping.csv)
    channels: dict[str, tuple[NDArray[Any], ChannelSpec]] = {}
    wanted = {**mapping.channels, **entry.channels}
    for name in sorted(wanted, key=lambda name: name == "time"):  # time last: it may need the length of the others
        where = f"{mapping_path}: channels.{name}"
        size = len(next(iter(channels.values()))[0]) if channels else 0
        channels[name] = _channel(name, wanted[name], source, file, where, mapping, size)
    lengths = {name: len(values) for name, (values, _) in channels.items()}
    if len(set(lengths.values())) != 1:
        listed = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise RecordingError(f"{file}: the variables differ in length ({listed}), they should be equally long.")
    channels, events = _checked_rows(channels, file, mapping.invalid_rows)
    channels["time"] = _from_zero(channels["time"])
    time = _si(channels["time"])
    rate = mapping.sample_rate or (1 / float(np.median(np.diff(time))) if time.size > 1 else None)
    if rate is None:
        raise RecordingError(f"{file}: has {time.size} rows, 'sample_rate' cannot be found from them and is not given.")
    started = entry.started_at or mapping.started_at
    if started is None:
        started = datetime.fromtimestamp(file.stat().st_mtime, UTC)
        events.append(Event(0.0, "info", "started_at is the modification time of the imported file"))
    header = RecordingHeader(
        recording_id=target.stem,
        campaign_id=mapping.campaign_id,
        kind=entry.kind or mapping.kind,
        started_at=as_utc(started),
        sample_rate=rate,
        source="import",
        setpoint=Setpoint(**entry.setpoint.model_dump()),
        gearbox=Gearbox(**mapping.gearbox.model_dump()),
        zero_id=mapping.zero_id,
        gearbox_serial=mapping.gearbox_serial,
        config=text,
        software=_software(),
        attributes={"imported_from": file.name},
    )
    listed_segments = mapping.segments if entry.segments is None else entry.segments
    segments = [_segment(segment, time, file) for segment in listed_segments]
    write_recording(target, header, channels, segments, events)


def _channel(
    name: str, wanted: ChannelMapping, source: Source, file: Path, where: str, mapping: Mapping, size: int
) -> tuple[NDArray[Any], ChannelSpec]:
    signal = BY_NAME.get(name)
    if wanted.variable is None and wanted.column is None:
        if name != "time" or wanted.rate is None:
            raise ConfigurationError(f"{where}: 'rate' is for time only, this channel needs 'variable' or 'column'.")
        spec = ChannelSpec.of("time", dtype="int64", scale=1 / wanted.rate, origin=f"{file.name}: {wanted.rate:g} Hz")
        return np.arange(size, dtype=np.int64), spec
    unit = unit_of(wanted.unit, where)
    meant = _LINEAR.get(unit.si, unit.si) if mapping.gearbox.ratio == 1.0 else unit.si
    if signal is not None and meant != signal.unit:
        raise ConfigurationError(f"{where}: unit '{wanted.unit}' should be one that becomes '{signal.unit}'.")
    raw = source.read(wanted.variable, wanted.column)
    if raw.dtype.kind == "f" or raw.dtype.kind not in "iu":
        raw = raw.astype(np.float64)
    if wanted.wraps_at is not None:
        raw = _unwrapped(raw, wanted.wraps_at)
    scale = _constant(wanted.scale, source, where, "scale")
    offset = _constant(wanted.offset, source, where, "offset")
    spec = ChannelSpec(
        name=name,
        unit=unit.si,
        dtype=str(raw.dtype.newbyteorder("=")),
        scale=scale * unit.factor,
        offset=offset * unit.factor + unit.offset,
        description=wanted.description or (signal.description if signal is not None else name),
        origin=f"{file.name}/{wanted.variable or f'column {wanted.column}'}",
    )
    return raw.astype(spec.dtype, copy=False), spec


def _unwrapped(raw: NDArray[Any], period: float) -> NDArray[Any]:
    """Count overflows: integers stay integers, and become int64."""
    if raw.dtype.kind in "iu":
        return np.unwrap(raw.astype(np.int64), period=int(period))
    return np.unwrap(raw, period=period)


def _constant(value: float | str, source: Source, where: str, key: str) -> float:
    if not isinstance(value, str):
        return value
    found = source.read(value, None)
    if found.size != 1:
        raise ConfigurationError(f"{where}.{key}: variable '{value}' holds {found.size} values, it should hold one.")
    return float(found[0])


def _checked_rows(
    channels: dict[str, tuple[NDArray[Any], ChannelSpec]], file: Path, invalid_rows: str
) -> tuple[dict[str, tuple[NDArray[Any], ChannelSpec]], list[Event]]:
    """Find rows that no recording may hold, and drop or refuse them."""
    good = np.ones(len(channels["time"][0]), dtype=bool)
    for name, (values, _) in channels.items():
        finite = np.isfinite(values)
        if invalid_rows == "refuse" and not finite.all():
            index = int(np.argmin(finite))
            raise RecordingError(f"{file}: {name} is {values[index]} at index {index}, every sample should be finite.")
        good &= finite
    time = np.where(good, _si(channels["time"]), -np.inf)
    later = time > np.maximum.accumulate(np.concatenate(([-np.inf], time[:-1])))
    if invalid_rows == "refuse" and not later.all():
        index = int(np.argmin(later))
        raise RecordingError(f"{file}: time at index {index} is not later than before, it should strictly increase.")
    good &= later
    if good.all():
        return channels, []
    kept = {name: (values[good], spec) for name, (values, spec) in channels.items()}
    if not good.any():
        raise RecordingError(f"{file}: holds no row without NaN and with increasing time.")
    dropped = int(np.sum(~good))
    first = int(np.argmin(good))
    text = f"{dropped} rows with NaN or without increasing time were left out, the first at index {first}"
    return kept, [Event(0.0, "warning", text)]


def _from_zero(channel: tuple[NDArray[Any], ChannelSpec]) -> tuple[NDArray[Any], ChannelSpec]:
    """Count time from the first sample."""
    values, spec = channel
    return values - values[0], ChannelSpec(
        spec.name, spec.unit, spec.dtype, spec.scale, 0.0, spec.description, spec.origin
    )


def _si(channel: tuple[NDArray[Any], ChannelSpec]) -> NDArray[np.float64]:
    values, spec = channel
    return np.asarray(values * spec.scale + spec.offset, dtype=np.float64)


def _segment(segment: SegmentMapping, time: NDArray[np.float64], file: Path) -> Segment:
    start = segment.start if segment.start_s is None else int(np.searchsorted(time, segment.start_s))
    stop = segment.stop if segment.stop_s is None else int(np.searchsorted(time, segment.stop_s))
    made = Segment(segment.name, start or 0, time.size if stop is None else stop)
    if not made.start < made.stop <= time.size:
        raise ConfigurationError(
            f"{file}: segment '{made.name}' would run from row {made.start} to {made.stop}, "
            f"it should lie within rows 0 to {time.size}."
        )
    return made


def _software() -> dict[str, str]:
    try:
        release = version("gearbench")
    except PackageNotFoundError:
        release = "unknown"
    return {"name": "gearbench", "version": release, "revision": "unknown"}
