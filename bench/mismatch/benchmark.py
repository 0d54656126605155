"""What a comparison costs: time by phase and memory for a folder, beside merely reading and plainly identifying it."""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.identification.identify import Options, identify_folder
from bench.mismatch.run import run
from bench.recording import Recording, RecordingFolder

READING, SEARCHING, SCORING = "reading", "searching", "scoring"
_PHASES = (("reading", READING), ("searching", SEARCHING), ("", SCORING))
"""how what a run says of its progress begins -> phase; the report's writing counts to the scoring"""


@dataclass(frozen=True, slots=True)
class MismatchFigures:
    """Wall and CPU times in s; peak memory in bytes of the process that compared and of those that read for it."""

    recordings: int
    samples: int
    verdict: str
    reading_s: float
    searching_s: float
    scoring_s: float
    cpu_s: float
    peak_memory: int
    read_s: float
    """merely reading every channel of every file"""
    identify_s: float | None
    """plain identification of the same folder, None where it cannot be identified"""

    @property
    def total_s(self) -> float:
        """Wall time of the whole comparison."""
        return self.reading_s + self.searching_s + self.scoring_s

    def as_dict(self) -> dict[str, Any]:
        """Return the figures for JSON, with the total and the ratios to reading and to identification."""
        identify = None if self.identify_s is None else self.total_s / self.identify_s
        return asdict(self) | {
            "total_s": self.total_s,
            "ratio_to_reading": self.total_s / self.read_s,
            "ratio_to_identify": identify,
        }


class _Clock:
    """Adds up the time between one word of progress and the next, by phase."""

    def __init__(self) -> None:
        self.spent = dict.fromkeys((READING, SEARCHING, SCORING), 0.0)
        self._phase, self._since = READING, time.perf_counter()

    def note(self, what: str, _share: float) -> None:
        """Take note that a run says what it does now."""
        now = time.perf_counter()
        self.spent[self._phase] += now - self._since
        self._phase, self._since = next(phase for begin, phase in _PHASES if what.startswith(begin)), now


def measure_mismatch(folder: Path, simulation: Path | None = None, jobs: int = 1) -> MismatchFigures:
    """Compare a folder, then read and identify it; the files are read once before, to be fair to the first.

    Raises RecordingError where the folder cannot be compared.
    """
    paths = [r.path for r in RecordingFolder.open(folder).recordings]
    read_s, samples = min(_read_all(paths) for _ in range(2))
    clock, begin, others = _Clock(), time.process_time(), _cpu_of_others()
    with tempfile.TemporaryDirectory() as out:
        report = run(folder, Path(out), simulation, clock.note, jobs=jobs)
    cpu_s = time.process_time() - begin + _cpu_of_others() - others
    peak = _peak(resource.RUSAGE_SELF) + (jobs * _peak(resource.RUSAGE_CHILDREN) if jobs > 1 else 0)
    begin = time.perf_counter()
    identify_s: float | None
    try:
        identify_folder(folder, Options(jobs=1))
        identify_s = time.perf_counter() - begin
    except BenchError:
        identify_s = None
    spent = clock.spent
    return MismatchFigures(
        len(paths),
        samples,
        report.verdict,
        spent[READING],
        spent[SEARCHING],
        spent[SCORING],
        cpu_s,
        peak,
        read_s,
        identify_s,
    )


def _cpu_of_others() -> float:
    """CPU seconds of the processes that have ended."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return ended.ru_utime + ended.ru_stime


def _peak(who: int) -> int:
    """Peak memory in bytes of this process, or of the largest of those that have ended."""
    return resource.getrusage(who).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def _read_all(paths: list[Path]) -> tuple[float, int]:
    begin, samples = time.perf_counter(), 0
    for path in paths:
        recording = Recording.open(path)
        recording.read_raw(list(recording.channels))
        samples += recording.size
    return time.perf_counter() - begin, samples
