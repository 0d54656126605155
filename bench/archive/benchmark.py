"""How fast the archive answers: recordings are made, indexed from nothing, and searched in every way there is."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from bench.archive.index import Index
from bench.archive.notes import Note, add_note
from bench.archive.query import Query
from bench.recording import ChannelSpec, Event, Gearbox, RecordingHeader, Segment, Setpoint, write_recording

_A_FOLDER = 250
_ROWS = 64
_FIRST = datetime(2026, 1, 5, 8, tzinfo=UTC)
_NAMES = (
    "time",
    "motor_angle",
    "load_angle",
    "motor_velocity",
    "motor_torque",
    "load_torque",
    "load_motor_torque",
    "temperature",
    "cycle",
)
_QUERIES: dict[str, Query] = {
    "everything": Query(),
    "words": Query(words="noise remark 17"),
    "words nobody said": Query(words="unobtainium"),
    "gearbox": Query(gearbox="SN-0003"),
    "dates": Query(since=_FIRST.timestamp() + 30 * 86400.0, until=_FIRST.timestamp() + 60 * 86400.0),
    "set point": Query(load_torque=300.0, velocity=math.radians(10.0)),
    "person and tag": Query(person="ann", tag="reference"),
    "result": Query(result="not passed", archived=True),
}


@dataclass(frozen=True, slots=True)
class ArchiveFigures:
    """Times in s: to index everything from nothing, and of each search the median and the slowest of its repeats.

    A search looks first whether folders changed; ``found`` is how many recordings each finds.
    """

    recordings: int
    folders: int
    index_s: float
    index_bytes: int
    median_s: dict[str, float]
    slowest_s: dict[str, float]
    found: dict[str, int]

    def as_dict(self) -> dict[str, Any]:
        """For ``--json``."""
        return asdict(self)


def measure_archive(
    root: Path, recordings: int, repeats: int = 7, report_progress: Callable[[str], None] = lambda _: None
) -> ArchiveFigures:
    """Make recordings below an empty root and measure; the files are real, of a few rows each.

    Parameters
    ----------
    root : folder for them, made if it is not there; recordings it holds already are used.
    recordings : how many there are to be.
    repeats : of each search.
    report_progress : called with a sentence before each step.
    """
    for first in range(0, recordings, _A_FOLDER):
        _make(root / f"campaign-{first // _A_FOLDER:04d}", first, min(_A_FOLDER, recordings - first))
        report_progress(f"{min(first + _A_FOLDER, recordings)} of {recordings} recordings made")
    path = root / ".archive.sqlite"
    index = Index(root, path)
    report_progress("indexing")
    begin = time.perf_counter()
    held = index.rebuild()
    index_s = time.perf_counter() - begin
    times: dict[str, list[float]] = {name: [] for name in _QUERIES}
    found = {}
    for _ in range(repeats):
        for name, query in _QUERIES.items():
            begin = time.perf_counter()
            index.refresh()
            found[name] = index.search(query).total
            times[name].append(time.perf_counter() - begin)
    return ArchiveFigures(
        held,
        -(-recordings // _A_FOLDER),
        index_s,
        path.stat().st_size,
        {name: statistics.median(one) for name, one in times.items()},
        {name: max(one) for name, one in times.items()},
        found,
    )


def _make(folder: Path, first: int, count: int) -> None:
    """Make a campaign folder, where it is not there: recordings of varied gearboxes, set points, dates and results."""
    if folder.exists():
        return
    part = folder.with_name(f".{folder.name}.part")
    part.mkdir(parents=True)
    specs = [ChannelSpec.of(name, dtype="int64", scale=5e-4 if name == "time" else 1.0) for name in _NAMES]
    rows = np.arange(_ROWS, dtype=np.int64)
    for number in range(first, first + count):
        recording_id = f"{number - first + 1:04d}-constant_velocity"
        write_recording(
            part / f"{recording_id}.h5",
            RecordingHeader(
                recording_id,
                folder.name,
                "constant_velocity",
                _FIRST + timedelta(minutes=15 * number),
                2000.0,
                "emulator",
                Setpoint(100.0 * (number % 7), math.radians(2.5 * (1 + number % 8)), 20.0 + 10.0 * (number % 4)),
                Gearbox(185.0),
                gearbox_serial=f"SN-{number // 1000:04d}",
                config=f'name = "bench-{number % 3}"\n',
            ),
            {spec.name: (rows, spec) for spec in specs},
            [Segment("steady", 0, _ROWS)],
            [Event(0.01, "info", f"remark {number}: unusual noise")] if number % 10 == 7 else [],
            accepted=number % 20 != 3,
        )
    for kind, text in (("person", ("Ann", "Bob", "Cleo")[first // _A_FOLDER % 3]), ("tag", "reference")):
        add_note(part, Note(_FIRST.isoformat(), "benchmark", kind, text))
    part.rename(folder)
