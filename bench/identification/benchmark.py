"""What identification costs: time and memory for a folder, beside merely reading its files."""

from __future__ import annotations

import resource
import sys
import time
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from bench.identification.identify import Options, identify_folder
from bench.identification.reduction import CHANNELS
from bench.processes import over
from bench.recording import Recording, RecordingFolder


@dataclass(frozen=True, slots=True)
class IdentifyFigures:
    """Wall times in s, peak memory in bytes (this process and the largest of its workers, added up)."""

    recordings: int
    samples: int
    jobs: int
    identify_s: float
    read_s: float
    read_used_s: float
    peak_memory: int

    @property
    def ratio(self) -> float:
        """Time to identify over time to read every channel of every file."""
        return self.identify_s / self.read_s

    def as_dict(self) -> dict[str, Any]:
        """Return the figures for JSON."""
        return asdict(self) | {"ratio": self.ratio}


def _read(path: Path, only: tuple[str, ...] | None) -> int:
    """Read the channels of one file as they stand in it; returns its number of samples."""
    recording = Recording.open(path)
    recording.read_raw([name for name in recording.channels if only is None or name in only])
    return recording.size


def _read_all(paths: list[Path], only: tuple[str, ...] | None, jobs: int) -> tuple[float, int]:
    begin = time.perf_counter()
    samples = sum(over(partial(_read, only=only), paths, jobs, chunk=2))
    return time.perf_counter() - begin, samples


def _peak_bytes(jobs: int) -> int:
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    child = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * (own + (jobs * child if jobs > 1 else 0))


def measure_identify(folder: Path, jobs: int = 2) -> IdentifyFigures:
    """Identify a folder and read its files with ``jobs`` processes; the files are read once before, to be fair."""
    paths = [r.path for r in RecordingFolder.open(folder).recordings]
    read_s, samples = min(_read_all(paths, None, jobs) for _ in range(2))
    read_used_s, _ = _read_all(paths, (*CHANNELS, "cycle"), jobs)
    begin = time.perf_counter()
    identify_folder(folder, Options(jobs=jobs))
    identify_s = time.perf_counter() - begin
    return IdentifyFigures(len(paths), samples, jobs, identify_s, read_s, read_used_s, _peak_bytes(jobs))
