"""The header of a recording from an open file: strict where an analysis would go wrong, tolerant elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from bench.errors import RecordingError
from bench.recording.file import attributes
from bench.recording.file.attributes import AttributeMissing, AttributeProblem
from bench.recording.file.channel_names import channel_names
from bench.recording.file.claims import check_around, check_channel, check_members
from bench.recording.file.samples import Places, look_up
from bench.recording.file.tolerant import columns_of, group_of, optional
from bench.recording.header import FORMAT, TEETH, ChannelSpec, Event, Gearbox, Segment, Setpoint

_REQUIRED: tuple[tuple[str, Callable[[Any], Any]], ...] = (
    ("recording_id", attributes.text),
    ("campaign_id", attributes.text),
    ("kind", attributes.text),
    ("started_at", attributes.moment),
    ("sample_rate", attributes.number),
    ("source", attributes.text),
)
_BENCH: tuple[tuple[str, Callable[[Any], Any]], ...] = (
    ("point_id", attributes.text),
    ("zero_id", attributes.text),
    ("take", attributes.integer),
    ("accepted", attributes.boolean),
    ("gearbox_serial", attributes.text),
    ("axis", attributes.text),
    ("imported_from", attributes.text),
    ("quality", attributes.json_object),
)
KNOWN_ROOT_ATTRIBUTES = frozenset(
    ("format", "format_version", "complete", *(name for name, _ in (*_REQUIRED, *_BENCH)))
)


def read_header(file: h5py.File, path: Path, *, prefix: bool = False) -> dict[str, Any]:
    """Read everything of a :class:`~bench.recording.Recording` but its samples, as keyword arguments.

    With ``prefix`` a complete recording of which rows are missing is taken as one that was cut short before them.

    Raises
    ------
    RecordingError
        No recording at all, a required root attribute is missing or unreadable, there is no usable channel, the
        channels of a complete recording differ in length or lack rows, or the file claims what it cannot hold.
    """
    problems: list[str] = []
    _check_format(file, path)
    check_around(file, path)
    result: dict[str, Any] = {}
    for name, kind in _REQUIRED:
        try:
            result[name] = attributes.read(file.attrs, name, kind)
        except AttributeProblem as problem:
            raise RecordingError(f"{path}: root {problem}.") from None
    if not result["sample_rate"] > 0:
        raise RecordingError(
            f"{path}: root attribute 'sample_rate' is {result['sample_rate']}, it should be above 0 Hz."
        )
    for name, kind in _BENCH:
        result[name] = optional(file.attrs, name, kind, None, f"{path}: root", problems)
    result["quality"] = result["quality"] or {}
    # A file without `complete`, or with it false, was cut short: that is the format, not a problem.
    result["complete"] = optional(file.attrs, "complete", attributes.boolean, False, f"{path}: root", problems)
    result["setpoint"] = _setpoint(file, path, problems)
    result["gearbox"] = _gearbox(file, path, problems)
    specs, sizes, result["places"] = _channels(file, path, problems)
    size = _size(path, sizes, result["complete"] and not prefix)
    result["complete"] = result["complete"] and size == max(size for size, _ in sizes.values())
    result["specs"], result["size"] = specs, size
    result["segments"] = _segments(file, path, size, result["complete"], problems)
    result["events"] = _events(file, path, problems)
    result["config"] = _config(file, path, problems)
    result["software"] = _software(file)
    result["problems"] = tuple(problems)
    return result


def _check_format(file: h5py.File, path: Path) -> None:
    try:
        form = attributes.read(file.attrs, "format", attributes.text)
        version = attributes.read(file.attrs, "format_version", attributes.text)
    except AttributeProblem as problem:
        raise RecordingError(f"{path}: not a recording, root {problem}.") from None
    if form != FORMAT:
        raise RecordingError(f"{path}: root attribute 'format' is '{form}', it should be '{FORMAT}'.")
    if version.split(".")[0] != "1":
        raise RecordingError(f"{path}: root attribute 'format_version' is '{version}', this reader knows 1.x.")


def _setpoint(file: h5py.File, path: Path, problems: list[str]) -> Setpoint:
    group = group_of(file, "setpoint", path, problems)
    if group is None:
        return Setpoint()
    where = f"{path}: /setpoint"
    values = {
        name: optional(group.attrs, name, attributes.number, float("nan"), where, problems)
        for name in ("load_torque", "velocity", "temperature")
    }
    return Setpoint(**values)  # type: ignore[arg-type]  # the default is a float, never None


def _gearbox(file: h5py.File, path: Path, problems: list[str]) -> Gearbox:
    group = group_of(file, "gearbox", path, problems)
    if group is None:
        return Gearbox()
    where = f"{path}: /gearbox"
    ratio = optional(group.attrs, "ratio", attributes.number, None, where, problems)
    if ratio is not None and not (np.isfinite(ratio) and ratio != 0):
        problems.append(f"{where} attribute 'ratio' is {ratio}, it should be a finite number other than 0.")
        ratio = None
    teeth = {name: optional(group.attrs, name, attributes.integer, None, where, problems) for name in TEETH}
    # what is no number of teeth is told by the rules, and used for nothing
    return Gearbox(ratio, **{name: number if number is None or number > 0 else None for name, number in teeth.items()})


def _channels(
    file: h5py.File, path: Path, problems: list[str]
) -> tuple[dict[str, ChannelSpec], dict[str, tuple[int, int]], dict[str, Places | None]]:
    """Give specification, rows claimed and stored, and places of each channel."""
    group = group_of(file, "channels", path, problems)
    if group is None:
        raise RecordingError(f"{path}: there is no group /channels, so there are no samples.")
    specs: dict[str, ChannelSpec] = {}
    sizes: dict[str, tuple[int, int]] = {}
    places: dict[str, Places | None] = {}
    check_members(group, path)
    for name in channel_names(group):
        where = f"{path}: /channels/{name}"
        try:
            dataset = group[name]
        except (OSError, KeyError, RuntimeError) as error:
            problems.append(f"{where} cannot be read ({error}).")
            continue
        if not isinstance(dataset, h5py.Dataset) or dataset.ndim != 1 or dataset.dtype.kind not in "iufb":
            problems.append(f"{where} is not a one-dimensional numeric dataset, it is left out.")
            continue
        check_channel(dataset, path, name)
        spec = _spec(name, dataset, where, problems)
        if spec is not None:
            stored, places[name] = look_up(dataset)
            specs[name], sizes[name] = spec, (dataset.shape[0], stored)
    if "time" not in specs:
        raise RecordingError(f"{path}: there is no usable channel /channels/time, the common time base of all others.")
    if len(specs) == 1:
        raise RecordingError(f"{path}: there is no channel beside /channels/time, so nothing was measured.")
    order = {name: index for index, name in enumerate(_order(specs))}
    return {name: specs[name] for name in sorted(specs, key=lambda name: order[name])}, sizes, places


def _size(path: Path, sizes: dict[str, tuple[int, int]], complete: bool) -> int:
    """Count the rows that every channel has; all of them where the recording says that it is complete."""
    shortest = min(sizes, key=lambda name: min(sizes[name]))
    claimed, stored = sizes[shortest]
    if not complete:
        return min(claimed, stored)
    longest = max(claimed for claimed, _ in sizes.values())
    if claimed != longest:
        raise RecordingError(
            f"{path}: /channels/{shortest} has {claimed} rows and /channels/time {sizes['time'][0]}; "
            "all channels of a complete recording should be equally long."
        )
    if stored < claimed:
        raise RecordingError(
            f"{path}: /channels/{shortest} claims {claimed} rows, those from index {stored} on were never stored."
        )
    return claimed


def _order(specs: dict[str, ChannelSpec]) -> list[str]:
    from bench.signals import BY_NAME

    return [name for name in BY_NAME if name in specs] + [name for name in specs if name not in BY_NAME]


def _spec(name: str, dataset: h5py.Dataset, where: str, problems: list[str]) -> ChannelSpec | None:
    attrs = dataset.attrs
    factors = {"scale": 1.0, "offset": 0.0}
    # both are written twice, the second time for xarray: where they differ, one was spoiled
    for key, twin in (("scale", "scale_factor"), ("offset", "add_offset")):
        try:
            factors[key] = attributes.read(attrs, key, attributes.number)
            if not np.isfinite(factors[key]) or (key == "scale" and factors[key] == 0):
                raise AttributeProblem(f"attribute '{key}' is {factors[key]}, it should be a finite factor")
            again = attributes.read(attrs, twin, attributes.number) if twin in attrs else factors[key]
            if again != factors[key]:
                raise AttributeProblem(f"attribute '{key}' is {factors[key]!r} and '{twin}' {again!r}, one is wrong")
        except AttributeMissing:
            continue
        except AttributeProblem as problem:
            # Values of unknown scale would be wrong values: better none.
            problems.append(f"{where} {problem}; the channel is left out.")
            return None
    texts = {
        key: optional(attrs, key, attributes.text, "", where, problems) or ""
        for key in ("unit", "description", "origin")
    }
    return ChannelSpec(
        name,
        texts["unit"],
        str(dataset.dtype),
        factors["scale"],
        factors["offset"],
        texts["description"],
        texts["origin"],
    )


def _segments(file: h5py.File, path: Path, size: int, complete: bool, problems: list[str]) -> tuple[Segment, ...]:
    columns = columns_of(file, "segments", ("name", "start", "stop"), path, problems)
    if columns is None:
        return ()
    segments: list[Segment] = []
    for index, (label, first, last) in enumerate(zip(*columns, strict=True)):
        where = f"{path}: /segments row {index}"
        try:
            name, start, stop = attributes.text(label), attributes.integer(first), attributes.integer(last)
        except ValueError:
            problems.append(f"{where} is not a name with two sample indices, it is left out.")
            continue
        stop = size if stop == -1 or (stop > size and not complete) else stop
        if not complete and start >= size:
            continue  # it began after the last row that was saved
        if not 0 <= start <= stop <= size:
            problems.append(
                f"{where} ('{name}') runs from {start} to {stop}, outside rows 0 to {size}; it is left out."
            )
            continue
        segments.append(Segment(name, start, stop))
    return tuple(segments)


def _events(file: h5py.File, path: Path, problems: list[str]) -> tuple[Event, ...]:
    columns = columns_of(file, "events", ("time", "level", "text"), path, problems)
    if columns is None:
        return ()
    events: list[Event] = []
    for index, (time, level, text) in enumerate(zip(*columns, strict=True)):
        try:
            events.append(Event(attributes.number(time), attributes.text(level), attributes.text(text)))
        except ValueError:
            problems.append(f"{path}: /events row {index} is not a time, a level and a text; it is left out.")
    return tuple(events)


def _config(file: h5py.File, path: Path, problems: list[str]) -> str | None:
    try:
        dataset = file.get("config")
        return attributes.text(dataset[()]) if isinstance(dataset, h5py.Dataset) else None
    except (OSError, KeyError, RuntimeError, ValueError) as error:
        problems.append(f"{path}: /config cannot be read as text ({error}).")
        return None


def _software(file: h5py.File) -> dict[str, str]:
    try:
        group = file.get("software")
    except (OSError, KeyError, RuntimeError):
        return {}
    if not isinstance(group, h5py.Group):
        return {}
    return {name: str(value) for name, value in group.attrs.items()}
