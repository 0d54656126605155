"""Recordings for colleagues' tools: MATLAB 5 files and CSV, in SI units."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from bench.errors import RecordingError
from bench.recording.reader import Recording

_BLOCK_ROWS = 1 << 16
_MAT5_LARGEST = 2**31 - 1
"""A variable of a MATLAB 5 file has a 32-bit length in bytes."""


def export_mat(recording: Recording, target: Path) -> None:
    """Write a MATLAB 5 file: one (N, 1) double a channel in SI, ``units``, ``segments``, ``events`` and ``header``.

    ``aux/NAME`` is called ``aux_NAME``: names of MATLAB know no slash.
    ``segments`` count as MATLAB does, from 1, with the last sample included.

    Raises
    ------
    RecordingError
        A channel is too long for the file format (2 GB a variable), or cannot be read.
    """
    import scipy.io

    if recording.size * 8 > _MAT5_LARGEST:
        raise RecordingError(
            f"{recording.path}: {recording.size} rows are too many for a MATLAB 5 file, "
            f"at most {_MAT5_LARGEST // 8}; export it as CSV, or read the HDF5 file with h5read."
        )
    contents: dict[str, Any] = {
        name.replace("/", "_"): values.reshape(-1, 1) for name, values in recording.read_si(recording.channels).items()
    }
    contents["units"] = {name.replace("/", "_"): spec.unit for name, spec in recording.specs.items()}
    contents["segments"] = {
        "name": np.array([s.name for s in recording.segments], dtype=object).reshape(-1, 1),
        "first": np.array([s.start + 1 for s in recording.segments], dtype=np.float64).reshape(-1, 1),
        "last": np.array([s.stop for s in recording.segments], dtype=np.float64).reshape(-1, 1),
    }
    contents["events"] = {
        "time": np.array([e.time for e in recording.events], dtype=np.float64).reshape(-1, 1),
        "level": np.array([e.level for e in recording.events], dtype=object).reshape(-1, 1),
        "text": np.array([e.text for e in recording.events], dtype=object).reshape(-1, 1),
    }
    contents["header"] = _header(recording)
    scipy.io.savemat(target, contents, do_compression=True, long_field_names=True)


def _header(recording: Recording) -> dict[str, Any]:
    optional = {
        "take": recording.take,
        "zero_id": recording.zero_id,
        "point_id": recording.point_id,
        "accepted": recording.accepted,
    }
    return {
        "recording_id": recording.recording_id,
        "campaign_id": recording.campaign_id,
        "kind": recording.kind,
        "started_at": recording.started_at.isoformat(),
        "sample_rate": recording.sample_rate,
        "source": recording.source,
        "complete": recording.complete,
        "setpoint": asdict(recording.setpoint),
        "gearbox": {name: value for name, value in asdict(recording.gearbox).items() if value is not None},
        **{name: value for name, value in optional.items() if value is not None},
    }


def export_csv(recording: Recording, target: Path) -> None:
    """Write a CSV file in SI: comment lines with ``#``, a line of ``name [unit]``, then one line a sample.

    The last column names the segment a sample belongs to. Numbers are printed so that reading them gives the same
    double again.
    """
    names = recording.channels
    with target.open("w", encoding="utf-8", newline="") as file:
        for key, value in _header(recording).items():
            file.write(f"# {key}: {value}\n")
        for event in recording.events:
            file.write(f"# event at {event.time!r} s, {event.level}: {' '.join(event.text.split())}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*(f"{name} [{recording.specs[name].unit}]" for name in names), "segment"])
        labels = _labels(recording)
        for start in range(0, recording.size, _BLOCK_ROWS):
            stop = min(start + _BLOCK_ROWS, recording.size)
            block = recording.read_si(names, start, stop)
            columns = [block[name].tolist() for name in names]
            writer.writerows(zip(*columns, labels(start, stop), strict=True))


def _labels(recording: Recording) -> Callable[[int, int], list[str]]:
    def labels(start: int, stop: int) -> list[str]:
        column = [""] * (stop - start)
        for segment in recording.segments:
            low, high = max(segment.start, start), min(segment.stop, stop)
            if low < high:
                column[low - start : high - start] = [segment.name] * (high - low)
        return column

    return labels


EXPORTERS: dict[str, Callable[[Recording, Path], None]] = {"mat": export_mat, "csv": export_csv}
"""Writers by the suffix of the file they make."""
