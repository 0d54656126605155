"""A mark that exists while a process may give torque: left behind, it shows that the run died, which is a stop.

A run that is killed, or loses its computer's power, latches nothing: nobody was left to do it. Whoever asks for the
latch next finds its mark; torque then takes the three acts, as after any other stop. Only a bench behind a network
interface has one: it stays powered when the process is gone.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from bench.configuration import BenchConfiguration
from bench.safety.latch_file import LatchFile, write_durably
from bench.safety.paths import state_folder

NAME = "torque.json"
CAUSE = "DIED"


def mark_path(bench: BenchConfiguration) -> Path | None:
    """Return where the mark of a bench stands, None for one in this process."""
    folder = state_folder(bench)
    return None if folder is None else folder / NAME


@contextmanager
def torque_mark(bench: BenchConfiguration, run: str, report_failure: Callable[[str], None]) -> Iterator[None]:
    """Keep a mark while this process may give torque; it is removed at the end, unless the process dies.

    ``run`` names it in the sentence. A folder that cannot be written is reported and no reason not to run: stops that
    somebody is left to see are latched all the same.
    """
    path = mark_path(bench)
    if path is None:
        yield
        return
    try:
        write_durably(path, {"pid": os.getpid(), "started": _process_identity(os.getpid()), "run": run, "at": _now()})
    except OSError as error:
        report_failure(
            f"if this process dies, nobody will know that it had torque: {path} cannot be written ({error.strerror})"
        )
    try:
        yield
    finally:
        with suppress(OSError):
            path.unlink(missing_ok=True)


def settle_death(bench: BenchConfiguration, latch: LatchFile) -> LatchFile:
    """Latch the stop of a run that died with torque, if one did; return the latch."""
    path = mark_path(bench)
    if path is None or not path.exists():
        return latch
    left = _read(path)
    if left is not None and _process_identity(left["pid"]) == left["started"]:
        return latch
    who = "a run" if left is None else f"the run {left['run']} (process {left['pid']}, begun {left['at'][:19]} UTC)"
    text = f"{who} ended without a word while it had torque; nobody has looked whether the shafts stand still"
    latch.stopped(CAUSE, text, datetime.now(UTC))
    if latch.settle() is None:
        # it is safe in the latch: the mark has said all it had to say
        with suppress(OSError):
            path.unlink(missing_ok=True)
    return latch


def _read(path: Path) -> dict[str, Any] | None:
    """Return what a mark says; None for one that cannot be read, which is one of a run that died writing it."""
    try:
        left = json.loads(path.read_text("utf-8"))
        return {"pid": int(left["pid"]), **{key: str(left[key]) for key in ("started", "run", "at")}}
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _process_identity(pid: int) -> str:
    """Return what identifies a process beside its id, empty if nothing does: its start and this boot."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text("ascii", "replace")
        boot = Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip()
    except OSError:
        return ""
    # the command's name may hold blanks and brackets; the start time is the 20th field after it
    fields = stat.rpartition(")")[2].split()
    return "" if fields[0] in ("Z", "X") else f"{fields[19]} {boot}"


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
