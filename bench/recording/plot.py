"""A picture of one recording: every channel over time, segments shaded, events marked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.recording.reader import Recording
from bench.recording.statistics import shown_unit

_POINTS = 2000
_MOST_PANELS, _MOST_MARKS, _MOST_LETTERS = 40, 500, 80
_PANEL_HEIGHT = 1.35
_SEGMENT_COLOURS = {
    "steady": "tab:green",
    "ramp_up": "tab:orange",
    "ramp_down": "tab:orange",
    "heat": "tab:red",
    "dwell": "tab:blue",
}


def plot_recording(recording: Recording, target: str | Path) -> Path:
    """Draw all channels of a recording into a PNG file; each point of a line stands for the range of its samples.

    The panel of a channel that cannot be read says so.

    Raises
    ------
    RecordingError
        The time cannot be read, or the picture cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    names = [name for name in recording.channels if name != "time"][:_MOST_PANELS]
    figure = Figure(figsize=(11, 1.2 + _PANEL_HEIGHT * len(names)), layout="constrained")
    FigureCanvasAgg(figure)
    panels = np.atleast_1d(figure.subplots(len(names), 1, sharex=True))
    time = recording.si("time")
    for panel, name in zip(panels, names, strict=True):
        unit, factor = shown_unit(recording.specs[name].unit)
        try:
            values = recording.si(name)
        except RecordingError:
            panel.text(0.5, 0.5, "cannot be read", ha="center", transform=panel.transAxes, fontsize=8)
        else:
            if time.size:
                _draw(panel, time, values * factor)
        label = f"{_printable(name)}\n[{_printable(unit)}]" if unit and unit != "1" else _printable(name)
        panel.set_ylabel(label, fontsize=7, parse_math=False)
        panel.tick_params(labelsize=7)
        _mark(panel, recording, time)
    panels[-1].set_xlabel("time [s]", fontsize=8)
    state = "" if recording.complete else ", cut short"
    title = f"{_printable(recording.recording_id)} ({_printable(recording.kind)}{state})"
    figure.suptitle(title, fontsize=10, parse_math=False)
    target = Path(target)
    try:
        figure.savefig(target, dpi=110)
    except OSError as error:
        raise RecordingError(f"{target}: the picture cannot be written ({error.strerror}).") from error
    return target


def _printable(text: str) -> str:
    """Shorten a text from a file, and replace characters that a font cannot draw."""
    return "".join(letter if letter.isprintable() else "?" for letter in text[:_MOST_LETTERS])


def _draw(panel: Any, time: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    starts, low, high = envelope(values, _POINTS)
    if np.array_equal(low, high, equal_nan=True):
        panel.plot(time[starts], low, linewidth=0.7)
    else:
        panel.fill_between(time[starts], low, high, linewidth=0.3, alpha=0.8, color="tab:blue")


def envelope(
    values: NDArray[np.float64], points: int
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Give first index, minimum and maximum of at most ``points`` stretches of equal length (NaN where one has any)."""
    step = max(-(-values.size // points), 1)
    starts = np.arange(0, values.size, step, dtype=np.int64)
    return starts, np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)


def _mark(panel: Any, recording: Recording, time: NDArray[np.float64]) -> None:
    for segment in recording.segments[:_MOST_MARKS]:
        if segment.start < segment.stop <= time.size:
            colour = _SEGMENT_COLOURS.get(segment.name, "tab:gray")
            panel.axvspan(time[segment.start], time[segment.stop - 1], color=colour, alpha=0.10, linewidth=0)
    for event in recording.events[:_MOST_MARKS]:
        if np.isfinite(event.time):
            panel.axvline(event.time, color="tab:red", linewidth=0.6, linestyle="--")
