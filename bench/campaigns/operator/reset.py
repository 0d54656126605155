"""The act after a stop that opens the bench: its drives' faults are taken away, and torque may be asked for again."""

from __future__ import annotations

from pathlib import Path

from bench.configuration import BenchFile
from bench.cycle.rig import Rig
from bench.errors import LimitError
from bench.safety import Act, Latch
from bench.safety.acts import latch_of
from bench.safety.latch import HOW, NEXT


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
