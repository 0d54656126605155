"""Predicted channels and residuals beside the measured ones: a copy of the recording, a table, a picture."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from bench.errors import RecordingError
from bench.exchange.predicted import Predicted
from bench.names import require_name
from bench.recording import RESIDUAL, SIMULATED
from bench.recording.plot import envelope
from bench.simulation.frame import FloatArray

_ROWS_AT_ONCE = 1 << 16
_POINTS = 2000


def write_copy(predicted: Predicted, out: Path) -> Path:
    """Write a copy of the recording with ``simulated/NAME`` and ``residual/NAME`` for each channel predicted.

    Raises
    ------
    RecordingError
        The copy would stand in the place of the recording, which is never touched; or it cannot be written.
    """
    source = predicted.recording.path
    target = out / f"{_name(predicted)}.h5"
    if target.resolve() == source.resolve():
        raise RecordingError(f"{target} is the recording itself, which stays as it is; give another folder with --out.")
    part = target.with_suffix(".h5.part")
    try:
        shutil.copyfile(source, part)
        with h5py.File(part, "r+") as file:
            group = file["channels"]
            for channel in predicted.channels:
                for prefix, values, what in (
                    (SIMULATED, channel.simulated, "as simulated"),
                    (RESIDUAL, channel.residual, "measured less simulated"),
                ):
                    _put(
                        group, prefix + channel.name, values, channel.unit, f"{channel.name.replace('_', ' ')}, {what}"
                    )
        part.replace(target)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise RecordingError(f"{target}: cannot be written ({error}).") from error
    return target


def _put(group: Any, name: str, values: FloatArray, unit: str, description: str) -> None:
    """Put a channel into a file, in place of one of that name; rows that a recording cut short lacks are NaN."""
    if name in group:
        del group[name]
    rows = group["time"].shape[0]
    padded = np.full(rows, np.nan)
    padded[: values.size] = values[:rows]
    dataset = group.create_dataset(name, data=padded, maxshape=(None,), chunks=True, shuffle=True, compression=1)
    for key, text in (("unit", unit), ("units", unit), ("description", description), ("origin", "bench predict")):
        dataset.attrs[key] = text
    dataset.attrs["scale"], dataset.attrs["offset"] = 1.0, 0.0
    if group["time"].is_scale:
        dataset.dims[0].attach_scale(group["time"])


def write_csv(predicted: Predicted, out: Path) -> Path:
    """Write a table: time, then each channel as measured, as simulated, and the residual, SI."""
    target = out / f"{_name(predicted)}.csv"
    columns: list[tuple[str, FloatArray]] = [("time [s]", predicted.recording.si("time"))]
    for channel in predicted.channels:
        columns += [
            (f"{channel.name} [{channel.unit}]", channel.measured),
            (f"{SIMULATED}{channel.name} [{channel.unit}]", channel.simulated),
            (f"{RESIDUAL}{channel.name} [{channel.unit}]", channel.residual),
        ]
    with target.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([name for name, _ in columns])
        for start in range(0, predicted.recording.size, _ROWS_AT_ONCE):
            part = [values[start : start + _ROWS_AT_ONCE].tolist() for _, values in columns]
            writer.writerows(zip(*part, strict=True))
    return target


WRITERS: dict[str, Callable[[Predicted, Path], Path]] = {"h5": write_copy, "csv": write_csv}
"""by the suffix of the file they make"""


def draw(predicted: Predicted, out: Path) -> Path:
    """Draw each channel as measured and as simulated, below it the residual; a PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    target = out / f"{_name(predicted)}.png"
    number = len(predicted.channels)
    figure = Figure(figsize=(11, 0.8 + 3.2 * number), layout="constrained")
    FigureCanvasAgg(figure)
    panels = np.atleast_1d(figure.subplots(2 * number, 1, sharex=True, height_ratios=[2, 1] * number))
    time = predicted.recording.si("time")
    for k, channel in enumerate(predicted.channels):
        upper, lower = panels[2 * k], panels[2 * k + 1]
        _band(upper, time, channel.measured, "tab:blue", "measured")
        _band(upper, time, channel.simulated, "tab:orange", "simulated")
        upper.legend(fontsize=7, loc="upper right")
        upper.set_ylabel(f"{channel.name.replace('_', ' ')}\n[{channel.unit}]", fontsize=8)
        _band(lower, time, np.where(channel.counts, channel.residual, np.nan), "tab:green", "residual")
        lower.axhline(0.0, color="black", linewidth=0.5)
        lower.set_ylabel(f"measured −\nsimulated [{channel.unit}]", fontsize=8)
    panels[-1].set_xlabel("time [s]", fontsize=8)
    for panel in panels:
        panel.tick_params(labelsize=7)
    figure.suptitle(predicted.recording.recording_id, fontsize=10, parse_math=False)
    figure.savefig(target, dpi=110)
    return target


def _band(panel: Any, time: FloatArray, values: FloatArray, colour: str, label: str) -> None:
    """A line each of whose points stands for the range of its samples."""
    if not time.size:
        return
    starts, low, high = envelope(values, _POINTS)
    panel.fill_between(time[starts], low, high, color=colour, alpha=0.5, linewidth=0.5, label=label)


def _name(predicted: Predicted) -> str:
    recording = predicted.recording
    return require_name(recording.recording_id, f"{recording.path}: the recording id", RecordingError)
