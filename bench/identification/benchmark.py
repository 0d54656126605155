"""What identification costs: time and memory beside merely reading the files, and what compression does to that."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import h5py
import numpy as np

from bench.identification.identify import Options, identify_folder
from bench.identification.samples.reduction import CHANNELS
from bench.processes import over
from bench.recording import Recording, RecordingFolder

COPIED = 8
"""Recordings that are written once more without filters, spread over all there are."""


@dataclass(frozen=True, slots=True)
class Cost:
    """Seconds by the clock, and of processors in all processes that were started for it."""

    wall_s: float
    processor_s: float


@dataclass(frozen=True, slots=True)
class Compression:
    """Some recordings as they are and without filters: bytes, and processor seconds to read every channel."""

    recordings: int
    rows: int
    bytes: int
    read_s: float
    plain_bytes: int
    plain_read_s: float

    @property
    def ratio(self) -> float:
        """Time to read them as they are over time to read them without filters."""
        return self.read_s / self.plain_read_s


@dataclass(frozen=True, slots=True)
class IdentifyFigures:
    """Costs; peak memory in bytes (this process and the largest of its workers, each counted in full)."""

    recordings: int
    samples: int
    jobs: int
    identify: Cost
    read: Cost
    read_used: Cost
    peak_memory: int
    compression: Compression

    @property
    def ratio(self) -> float:
        """Time to identify over time to read every channel of every file, by the clock."""
        return self.identify.wall_s / self.read.wall_s

    @property
    def processor_ratio(self) -> float:
        """The same of processor seconds, which other programs on the machine change less."""
        return self.identify.processor_s / self.read.processor_s

    def as_dict(self) -> dict[str, Any]:
        """Return the figures for JSON."""
        return asdict(self) | {
            "ratio": self.ratio,
            "processor_ratio": self.processor_ratio,
            "compression_ratio": self.compression.ratio,
        }


def _processor_s() -> float:
    """Processor seconds of this process and of its children that have ended."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in used)


def _cost(work: Callable[[], Any]) -> tuple[Cost, Any]:
    begin, used = time.perf_counter(), _processor_s()
    result = work()
    return Cost(time.perf_counter() - begin, _processor_s() - used), result


def _read(path: Path, only: tuple[str, ...] | None) -> int:
    """Read the channels of one file as they stand in it; returns its number of samples."""
    recording = Recording.open(path)
    recording.read_raw([name for name in recording.channels if only is None or name in only])
    return recording.size


def _read_all(paths: list[Path], only: tuple[str, ...] | None, jobs: int) -> tuple[Cost, int]:
    return _cost(lambda: sum(over(partial(_read, only=only), paths, jobs, chunk=2)))


def _peak_bytes(jobs: int) -> int:
    parent = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    child = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * (parent + (jobs * child if jobs > 1 else 0))


def _without_filters(path: Path, folder: Path) -> Path:
    """Copy a recording with its datasets as they are in memory, chunk for chunk."""
    copy = folder / path.name
    with h5py.File(path, "r") as source, h5py.File(copy, "w") as target:
        target.attrs.update(source.attrs)

        def put(name: str, item: h5py.Group | h5py.Dataset) -> None:
            if isinstance(item, h5py.Dataset):
                new = target.create_dataset(name, data=item[()], chunks=item.chunks, maxshape=item.maxshape)
            else:
                new = target.require_group(name)
            new.attrs.update(item.attrs)

        source.visititems(put)
    return copy


def measure_compression(paths: list[Path]) -> Compression:
    """Read recordings as they are and as copies without filters, three times each in turns; the least counts."""
    chosen = [paths[i] for i in np.unique(np.linspace(0, len(paths) - 1, COPIED).astype(int))]
    with TemporaryDirectory() as folder:
        copies = [_without_filters(path, Path(folder)) for path in chosen]
        costs = [(_read_all(chosen, None, 1), _read_all(copies, None, 1)) for _ in range(3)]
        sizes = [sum(path.stat().st_size for path in group) for group in (chosen, copies)]
    read_s, plain_s = (min(row[i][0].processor_s for row in costs) for i in (0, 1))
    return Compression(len(chosen), costs[0][0][1], sizes[0], read_s, sizes[1], plain_s)


def measure_identify(folder: Path, jobs: int = 2) -> IdentifyFigures:
    """Identify a folder and read its files with ``jobs`` processes; the files are read once before, to be fair."""
    paths = [r.path for r in RecordingFolder.open(folder).recordings]
    read, samples = min((_read_all(paths, None, jobs) for _ in range(2)), key=lambda row: row[0].wall_s)
    read_used, _ = _read_all(paths, (*CHANNELS, "cycle"), jobs)
    identified, _ = _cost(lambda: identify_folder(folder, Options(jobs=jobs)))
    peak = _peak_bytes(jobs)
    return IdentifyFigures(len(paths), samples, jobs, identified, read, read_used, peak, measure_compression(paths))
