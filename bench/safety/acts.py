"""What an operator does after a stop (:mod:`bench.safety.latch`), on a bench and a run; opens no bench."""

from __future__ import annotations

from pathlib import Path

from bench.configuration import BenchFile
from bench.safety.latch import Act, Latch, Standing
from bench.safety.latch_file import LatchFile
from bench.safety.paths import latch_path, machine_latch_path
from bench.safety.torque_mark import settle_death


def latch_of(file: BenchFile, folder: Path) -> LatchFile:
    """Return the latch of a bench; ``folder`` is that of the run, where an emulated bench keeps it.

    A run that died with torque is a stop: it is latched here, by whoever asks first.
    """
    bench = file.configuration
    return settle_death(bench, LatchFile(latch_path(bench, folder), machine_latch_path(bench)))


def acknowledge(file: BenchFile, folder: Path, by: str) -> Latch:
    """Store that somebody has read why the bench stopped; nothing else happens.

    Raises
    ------
    LimitError
        If that is not the act that is due.
    """
    return latch_of(file, folder).act(Act.ACKNOWLEDGE, by)


def require_resumable(latch: LatchFile, resumes: bool, run: Path | None = None) -> None:
    """Refuse a run on a bench that was stopped, unless it was reset and this run is to resume.

    Raises
    ------
    LimitError
        With what stopped the bench and which act is due.
    """
    standing = latch.read()
    if not (resumes and standing.standing is Standing.RESET):
        # a latch in memory has no place, one in the folder of a run is asked for by it
        standing.require_clear("" if run is None else f" {run}")


def resume(latch: LatchFile, by: str) -> None:
    """Let torque be given again, where a stop was reset; nothing where there was none."""
    if latch.read().standing is not Standing.CLEAR:
        latch.act(Act.RESUME, by)
