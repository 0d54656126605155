"""Rules on the channels: layout, units, stored rows, and the common time base."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from bench.recording.file import attributes
from bench.recording.file.attributes import AttributeProblem
from bench.recording.file.channel_names import channel_names
from bench.recording.file.storage import first_missing_row
from bench.recording.rules.findings import Finding
from bench.recording.times import not_increasing
from bench.signals import BY_NAME, REQUIRED

_BLOCK_ROWS = 1 << 19
_UNIT_SPELLINGS = {"N*m": "N·m", "N m": "N·m", "Nm": "N·m", "degC": "°C", "": "1", "rad s-1": "rad/s"}
_LINEAR_UNITS = {"rad": "m", "rad/s": "m/s", "N·m": "N"}
_RATE_TOLERANCE = 0.05


def _datasets(file: h5py.File) -> dict[str, h5py.Dataset]:
    """Give the channels that can be looked at: one-dimensional numeric datasets."""
    group = file.get("channels")
    if not isinstance(group, h5py.Group):
        return {}
    found = {name: group.get(name) for name in channel_names(group)}
    return {
        name: dataset
        for name, dataset in found.items()
        if isinstance(dataset, h5py.Dataset) and dataset.ndim == 1 and dataset.dtype.kind in "iufb"
    }


def _complete(file: h5py.File) -> bool:
    try:
        return attributes.read(file.attrs, "complete", attributes.boolean)
    except AttributeProblem:
        return False


def _text(attrs: Any, name: str) -> str:
    try:
        return attributes.read(attrs, name, attributes.text)
    except AttributeProblem:
        return ""


def channel_layout(file: h5py.File, path: Path) -> Iterator[Finding]:
    """Check that channels are one-dimensional, of allowed types, equally long, with ``time`` as their scale."""
    group = file.get("channels")
    if not isinstance(group, h5py.Group):
        yield "/channels", "is missing, it should be the group of all samples", False
        return
    usable = _datasets(file)
    imported = _text(file.attrs, "source") == "import"
    for name in channel_names(group):
        where = f"/channels/{name}"
        if name not in usable:
            yield where, "is not a readable one-dimensional numeric dataset", False
            continue
        dtype = usable[name].dtype
        if dtype.kind == "f" and dtype.itemsize < 8:
            yield where, f"is {dtype}, it should be an integer as the device gave it, or float64", False
        signal = BY_NAME.get(name)
        if signal is not None and signal.quantity == "angle" and not imported and dtype != np.dtype("int64"):
            yield where, f"is {dtype}, an angle should be extended to int64 by counting overflows", False
    lengths = {name: dataset.shape[0] for name, dataset in usable.items()}
    if "time" in lengths:
        for name, length in lengths.items():
            if length != lengths["time"]:
                text = f"has {length} rows and /channels/time {lengths['time']}, they should be equal"
                yield f"/channels/{name}", text, not _complete(file)
        yield from _dimension_scale(usable)


def _dimension_scale(usable: dict[str, h5py.Dataset]) -> Iterator[Finding]:
    time = usable["time"]
    if not time.is_scale:
        yield "/channels/time", "is not an HDF5 dimension scale, it should be the scale of all channels", False
        return
    for name, dataset in usable.items():
        if name != "time" and time not in dataset.dims[0].values():
            yield f"/channels/{name}", "does not have /channels/time as its dimension scale", False


def channel_units(file: h5py.File, path: Path) -> Iterator[Finding]:
    """Check unit, scale, offset, description and origin of each channel."""
    linear = _is_linear(file)
    for name, dataset in _datasets(file).items():
        where = f"/channels/{name}"
        for key in ("unit", "description", "origin"):
            try:
                attributes.read(dataset.attrs, key, attributes.text)
            except AttributeProblem as problem:
                yield where, str(problem), False
        for key in ("scale", "offset"):
            if key not in dataset.attrs:
                continue
            try:
                value = attributes.read(dataset.attrs, key, attributes.number)
            except AttributeProblem as problem:
                yield where, str(problem), False
                continue
            if not np.isfinite(value) or (key == "scale" and value == 0):
                yield (
                    where,
                    f"attribute '{key}' is {value}, it should be finite{' and not 0' * (key == 'scale')}",
                    False,
                )
        if name in BY_NAME and "unit" in dataset.attrs:
            expected = BY_NAME[name].unit
            unit = _text(dataset.attrs, "unit")
            allowed = {expected, _LINEAR_UNITS.get(expected, expected) if linear else expected}
            if _UNIT_SPELLINGS.get(unit, unit) not in allowed:
                yield where, f"attribute 'unit' is '{unit}', it should be '{expected}'", False


def _is_linear(file: h5py.File) -> bool:
    """Whether this may be a linear axis: an import with ratio 1, which has m and N in place of rad and N·m."""
    try:
        ratio = attributes.read(file["gearbox"].attrs, "ratio", attributes.number)
    except (AttributeProblem, KeyError, AttributeError):
        return False
    return ratio == 1.0 and _text(file.attrs, "source") == "import"


def required_channels(file: h5py.File, path: Path) -> Iterator[Finding]:
    """Check that the channels the source must have are there."""
    names = set(_datasets(file))
    if not names:
        yield "/channels", "holds no channel", False
        return
    if _text(file.attrs, "source") == "import":
        if "time" not in names:
            yield "/channels/time", "is missing, every recording should have it", False
        if not names - {"time", "cycle"}:
            yield "/channels", "holds no measured channel, an import should have at least one", False
        return
    for name in REQUIRED:
        if name not in names:
            # Decimated recordings leave `cycle` out, and nothing in the file says whether it is one.
            decimated = " (allowed in a decimated recording)" if name == "cycle" else ""
            yield f"/channels/{name}", f"is missing, the bench records it always{decimated}", bool(decimated)


def stored_rows(file: h5py.File, path: Path) -> Iterator[Finding]:
    """Read every channel to its end: stored, readable, and numbers."""
    for name, dataset in _datasets(file).items():
        where = f"/channels/{name}"
        missing = first_missing_row(dataset)
        if missing is not None:
            yield where, f"rows from index {missing} on were never stored", not _complete(file)
        rows = dataset.shape[0] if missing is None else missing
        for start in range(0, rows, _BLOCK_ROWS):
            stop = min(start + _BLOCK_ROWS, rows)
            try:
                block = dataset[start:stop]
            except (OSError, RuntimeError) as error:
                yield where, f"rows {start} to {stop} cannot be read ({error})", False
                break
            if block.dtype.kind == "f" and not np.isfinite(block).all():
                index = int(np.argmin(np.isfinite(block)))
                text = f"at index {start + index} is {block[index]}, every sample should be a finite number"
                yield where, text, False
                break


def time_and_cycle(file: h5py.File, path: Path) -> Iterator[Finding]:
    """Check that time starts at 0 and increases, and that lost cycles show in time and in an event."""
    usable = _datasets(file)
    if "time" not in usable or not usable["time"].shape[0]:
        if "time" in usable:
            yield "/channels/time", "holds no rows", _complete(file) is False
        return
    try:
        rate = attributes.read(file.attrs, "sample_rate", attributes.number)
    except AttributeProblem:
        return  # another rule says so
    if not rate > 0:
        return
    time = _si(usable["time"])
    if not time.size:
        return  # the rule on stored rows says so
    if abs(time[0]) > 0.5 / rate:
        yield "/channels/time", f"starts at {time[0]:g} s, it should start at 0 with the first sample", False
    text = not_increasing(time)
    if text is not None:
        yield "/channels/time", text, False
        return
    steps = np.diff(time)
    if steps.size and abs(float(np.median(steps)) * rate - 1) > _RATE_TOLERANCE:
        text = f"steps by {np.median(steps):g} s, root attribute 'sample_rate' {rate:g} Hz says {1 / rate:g} s"
        yield "/channels/time", text, False
    if "cycle" in usable and (first_missing_row(usable["cycle"]) or usable["cycle"].shape[0]) == time.size:
        yield from _cycle(file, _stored_rows(usable["cycle"]).astype(np.int64), time, rate)


def _cycle(file: h5py.File, cycle: NDArray[np.int64], time: NDArray[np.float64], rate: float) -> Iterator[Finding]:
    steps = np.diff(cycle)
    where = "/channels/cycle"
    backwards = np.flatnonzero(steps < 1)
    if backwards.size:
        index = int(backwards[0]) + 1
        yield where, f"at index {index} is {cycle[index]} after {cycle[index - 1]}, it should increase", False
        return
    gaps = np.flatnonzero(steps > 1)
    if not gaps.size:
        return
    lost = int(np.sum(steps[gaps] - 1))
    yield where, f"has {gaps.size} gaps with {lost} lost cycles, the first at index {int(gaps[0]) + 1}", True
    for index in gaps[np.diff(time)[gaps] < 1.5 / rate][:1]:
        text = f"steps by {steps[index]} at index {index + 1}, /channels/time should step likewise"
        yield where, f"{text} (it steps by {time[index + 1] - time[index]:.6g} s)", False
    if not _event_times(file).size:
        yield where, f"has a gap at index {int(gaps[0]) + 1}, /events should say so and is empty", False


def _event_times(file: h5py.File) -> NDArray[np.float64]:
    group = file.get("events")
    if not isinstance(group, h5py.Group) or "time" not in group:
        return np.empty(0)
    return np.asarray(group["time"][()], dtype=np.float64)


def _stored_rows(dataset: h5py.Dataset) -> NDArray[Any]:
    """Read the rows before the first that was never stored."""
    return np.asarray(dataset[: first_missing_row(dataset)])


def _si(dataset: h5py.Dataset) -> NDArray[np.float64]:
    values = _stored_rows(dataset).astype(np.float64)
    scale = attributes.number(dataset.attrs["scale"]) if "scale" in dataset.attrs else 1.0
    offset = attributes.number(dataset.attrs["offset"]) if "offset" in dataset.attrs else 0.0
    return np.asarray(values * scale + offset, dtype=np.float64)
