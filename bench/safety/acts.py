"""What an operator does after a stop: acknowledge, reset, resume (:mod:`bench.safety.latch`), on a bench and a run."""

from __future__ import annotations

from pathlib import Path

from bench.configuration import BenchFile
from bench.cycle.rig import Rig
from bench.errors import LimitError
from bench.safety import Act, Latch, LatchFile, Standing
from bench.safety.latch import HOW, NEXT
from bench.safety.places import latch_path, machine_latch_path
from bench.safety.torque_mark import settle_death


def latch_of(file: BenchFile, folder: Path) -> LatchFile:
    """Return the latch of a bench; ``folder`` is that of the run, where an emulated bench keeps it.

    A run that died with torque is a stop: it is latched here, by whoever asks first.
    """
    bench = file.configuration
    return settle_death(bench, LatchFile(latch_path(bench, folder), machine_latch_path(bench)))


def acknowledge(file: BenchFile, folder: Path, by: str) -> Latch:
    """Say that somebody has read why the bench stopped; nothing else happens.

    Raises
    ------
    LimitError
        If that is not the act that is due.
    """
    return latch_of(file, folder).act(Act.ACKNOWLEDGE, by)


def reset(file: BenchFile, folder: Path, by: str, *, seed: int = 0) -> Latch:
    """Open the bench, take the drives' faults away, and look whether the cause is gone; no torque is given.

    Without a stop on record only faults that the drives show from before are taken away.

    Raises
    ------
    LimitError
        If the stop was not acknowledged, or a limit or safety circuit still asks for a stop.
    DeviceError
        If the bench cannot be opened or a fault does not go away.
    """
    latch = latch_of(file, folder)
    due = NEXT[latch.read().standing]
    if due not in (Act.RESET, None):
        raise LimitError(f"the bench cannot reset now: {due.value} comes first ({HOW[due]})")
    with Rig(file, seed=seed, latch=latch) as rig:
        rig.reset_faults()
        verdict = rig.look()
        if verdict.tripped:
            raise LimitError(f"the bench cannot reset now: {verdict.text}")
    return latch.read() if due is None else latch.act(Act.RESET, by)


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
