"""Rules on the tables ``segments`` and ``events``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.recording.file import attributes
from bench.recording.header import SEGMENT_NAMES
from bench.recording.reader import Recording
from bench.recording.rules.findings import Finding

_REVOLUTION_KINDS = ("constant_velocity", "validation")


def _table(file: h5py.File, name: str, columns: dict[str, str]) -> Iterator[Finding]:
    """Check that a group holds these one-dimensional datasets in equal length; ``columns`` maps to NumPy kinds."""
    group = file.get(name)
    if not isinstance(group, h5py.Group):
        yield f"/{name}", f"is missing, it should be a group with the datasets {', '.join(columns)}", False
        return
    lengths: set[int] = set()
    for column, dtype in columns.items():
        dataset = group.get(column)
        if not isinstance(dataset, h5py.Dataset) or dataset.ndim != 1:
            yield f"/{name}/{column}", "is missing or not one-dimensional", False
            return
        found = "str" if h5py.check_string_dtype(dataset.dtype) else str(dataset.dtype)
        # An empty table says nothing wrong, whatever type a library gives to no strings.
        if found != dtype and dataset.shape[0]:
            yield f"/{name}/{column}", f"is {found}, it should be {dtype}", False
        lengths.add(dataset.shape[0])
    if len(lengths) > 1:
        yield f"/{name}", f"has columns of {sorted(lengths)} rows, they should be equally long", False


def segments(file: h5py.File, path: Path) -> Iterator[Finding]:
    """Check names, order and bounds of segments, and that steady motion covers a revolution."""
    wrong = list(_table(file, "segments", {"name": "str", "start": "int64", "stop": "int64"}))
    yield from wrong
    if any("missing" in text or "columns" in text for _, text, _ in wrong):
        return
    try:
        recording = Recording.open(path)
    except RecordingError:
        return  # other rules say why
    group = file["segments"]
    names = attributes.strings(group["name"][()]) if group["name"].shape[0] else []
    for index, (name, start, stop) in enumerate(zip(names, group["start"][()], group["stop"][()], strict=True)):
        where = f"/segments row {index} ('{name}')"
        if name not in SEGMENT_NAMES:
            yield where, f"has a name that is not one of {', '.join(SEGMENT_NAMES)}", False
        if stop == -1:
            if recording.complete:
                yield where, f"is still open (stop -1) in a complete recording: it ends at {recording.size}", True
            continue
        if not 0 <= start <= stop or (recording.complete and stop > recording.size):
            yield where, f"runs from {start} to {stop}, it should lie within rows 0 to {recording.size}", False
    yield from _revolutions(recording)


def _revolutions(recording: Recording) -> Iterator[Finding]:
    if recording.kind not in _REVOLUTION_KINDS or not recording.complete:
        return
    if not recording.steady():
        yield "/segments", f"holds no 'steady', a {recording.kind} recording should have one", False
    for part in recording.steady():
        travel = _travel(recording, part)
        if travel is not None and travel < 2 * math.pi:
            where = f"/segments 'steady' rows {part.start} to {part.stop}"
            yield where, f"cover {travel / (2 * math.pi):.3f} revolutions of the load side, at least 1 is due", False


def _travel(recording: Recording, part: slice) -> float | None:
    """Give the load-side travel (rad) of a segment, one sample's more than between its ends; None where unknown."""
    source, divisor = "load_angle", 1.0
    if source not in recording.channels:
        source, divisor = "motor_angle", abs(recording.gearbox.ratio or math.nan)
    if source not in recording.channels or recording.specs[source].unit != "rad" or math.isnan(divisor):
        return None
    if part.stop - part.start < 2:
        return 0.0
    ends = [recording.si(source, at, at + 1)[0] for at in (part.start, part.stop - 1)]
    samples = part.stop - part.start
    return float(abs(ends[1] - ends[0]) / divisor * samples / (samples - 1))


def events(file: h5py.File, path: Path) -> Iterator[Finding]:
    """Check the table of events."""
    wrong = list(_table(file, "events", {"time": "float64", "level": "str", "text": "str"}))
    yield from wrong
    if wrong:
        return
    times: NDArray[Any] = file["events"]["time"][()]
    for index in np.flatnonzero(~np.isfinite(times)):
        yield f"/events/time row {index}", f"is {times[index]}, it should be seconds since the first sample", False
