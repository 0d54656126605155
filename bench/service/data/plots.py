"""A recording as a page plots it: a stretch of time in 800 parts, with its extremes, its mean, and its gaps."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.recording import Recording
from bench.recording.statistics import shown_unit

PLOTTED: tuple[str, ...] = (
    "motor_velocity",
    "load_velocity",
    "load_torque",
    "load_motor_torque",
    "motor_torque",
    "temperature",
)
"""Channels a page shows of a recording, where it has them."""
_BUCKETS = 800
_BLOCK_ROWS = 1 << 20
_MOST_GAPS = 200


def plot(path: Path, start_s: float = 0.0, stop_s: float | None = None) -> dict[str, Any]:
    """Return a stretch of a recording as a page plots it: minimum, mean and maximum of 800 parts, events, segments.

    ``time`` is that of the samples, in s since the first. Where cycles were lost for longer than one, an entry without
    values stands between the parts before and after: a gap is drawn as a gap.

    Parameters
    ----------
    path : of the recording.
    start_s, stop_s : the stretch, s since the first sample; None for its end.

    Raises
    ------
    RecordingError
        If the file cannot be read.
    """
    recording = Recording.open(path)
    names = [name for name in PLOTTED if name in recording.channels]
    times = recording.si("time")
    first, last = _stretch(times, start_s, stop_s)
    gaps = _gaps(times[first:last], recording.sample_rate) + first
    parts = np.linspace(first, last, min(_BUCKETS, max(1, last - first)) + 1).astype(np.int64)
    edges = np.unique(np.concatenate((parts, gaps)))
    low, mean, high = (np.full((len(names), edges.size - 1), np.nan) for _ in range(3))
    # whole parts of at most a million rows, so that an hour of recording costs little memory
    for begin, end in _groups(edges):
        rows = recording.read_si(names, int(edges[begin]), int(edges[end]))
        starts = edges[begin:end] - edges[begin]
        for i, name in enumerate(names if last > first else ()):
            low[i, begin:end] = np.minimum.reduceat(rows[name], starts)
            high[i, begin:end] = np.maximum.reduceat(rows[name], starts)
            mean[i, begin:end] = np.add.reduceat(rows[name], starts) / np.diff(edges[begin : end + 1])
    middle = (times[edges[:-1]] + times[edges[1:] - 1]) / 2.0 if last > first else np.full(edges.size - 1, start_s)
    # between the last sample before a gap and the first after it
    at = np.searchsorted(edges, gaps)
    middle = np.insert(middle, at, (times[gaps - 1] + times[gaps]) / 2.0)
    low, mean, high = (np.insert(values, at, np.nan, axis=1) for values in (low, mean, high))
    rate = recording.sample_rate
    return {
        "id": recording.recording_id,
        "kind": recording.kind,
        "gearbox": recording.gearbox_serial,
        "started_at": recording.started_at.isoformat(),
        "time": [round(float(value), 5) for value in middle],
        "duration_s": float(times[-1]) if times.size else 0.0,
        "gaps": gaps.size,
        "channels": {name: _channel(recording, name, low[i], mean[i], high[i]) for i, name in enumerate(names)},
        "segments": [{"name": s.name, "start": s.start / rate, "stop": s.stop / rate} for s in recording.segments],
        "events": [{"time": e.time, "level": e.level, "text": e.text} for e in recording.events],
        "quality": recording.quality,
        "problems": list(recording.problems),
    }


def _stretch(times: NDArray[np.float64], start_s: float, stop_s: float | None) -> tuple[int, int]:
    """Rows of a stretch of time; at least one, where there are any."""
    first = int(np.searchsorted(times, start_s, side="left"))
    last = times.size if stop_s is None else int(np.searchsorted(times, stop_s, side="right"))
    first = min(first, max(0, times.size - 1))
    return first, max(last, min(first + 1, times.size))


def _gaps(times: NDArray[np.float64], rate: float) -> NDArray[np.int64]:
    """Rows before which cycles were lost; the longest, if there are more than a plot can show."""
    missing = np.diff(times) * rate
    rows = np.flatnonzero(missing > 1.5)
    if rows.size > _MOST_GAPS:
        rows = np.sort(rows[np.argsort(missing[rows])[-_MOST_GAPS:]])
    return (rows + 1).astype(np.int64)


def _groups(edges: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """Give the parts in groups of at most a million rows, or one part."""
    begin = 0
    while begin < edges.size - 1:
        end = int(np.searchsorted(edges, edges[begin] + _BLOCK_ROWS, side="right")) - 1
        end = min(max(end, begin + 1), edges.size - 1)
        yield begin, end
        begin = end


def _channel(
    recording: Recording, name: str, low: NDArray[np.float64], mean: NDArray[np.float64], high: NDArray[np.float64]
) -> dict[str, Any]:
    unit, factor = shown_unit(recording.specs[name].unit)
    if name == "motor_velocity" and recording.gearbox.ratio and unit == "°/s":
        # at the load side, where set points are
        factor /= recording.gearbox.ratio
    return {"unit": unit, "low": short(low * factor), "mean": short(mean * factor), "high": short(high * factor)}


def short(values: NDArray[np.float64]) -> list[float | None]:
    """Five digits of each value, None where there is none."""
    return [float(f"{value:.5g}") if np.isfinite(value) else None for value in values]
