"""Where what must outlive a run is kept: latch, commissioning record, lock of a bench on a network interface.

A bench that is emulated in the program's own process ends with it; its latch stands in the folder of the run. One
behind a network interface stays powered, whoever comes next, so its state belongs to the bench: a folder of its own
under ``$BENCH_STATE``, else ``$XDG_STATE_HOME/gearbench``, else ``~/.local/state/gearbench``.

A stop is kept in two more places, so that neither another state folder nor a disk that fails forgets it: under the name
of the interface in ``/var/tmp``, for every user of this machine, and in memory (``/dev/shm``) until it is safe on disk.
``$BENCH_MACHINE`` gives a folder for both instead (for tests).
"""

from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path

from bench.configuration import BenchConfiguration

VARIABLE = "BENCH_STATE"
MACHINE = "BENCH_MACHINE"
LATCH = "latch.json"
_PERSISTENT, _VOLATILE = Path("/var/tmp"), Path("/dev/shm")
"""Folders of all users: no link in them is followed."""


def state_folder(bench: BenchConfiguration) -> Path | None:
    """Return the folder of a bench behind a network interface, None for one in this process."""
    if bench.bus.in_process:
        return None
    return state_root() / _safe(f"{bench.name}@{bench.bus.interface}")


def latch_path(bench: BenchConfiguration, run: Path) -> Path:
    """Return where the latch of a bench stands; ``run`` is the folder of the run."""
    return (state_folder(bench) or run) / LATCH


def machine_latch_path(bench: BenchConfiguration) -> Path | None:
    """Return where this machine remembers a stop of the bench on an interface; None for a bench in this process."""
    if bench.bus.in_process:
        return None
    return _folder_from_environment(_PERSISTENT) / f"gearbench-latch-{_safe(bench.bus.interface)}.json"


def spare_path(latch: Path) -> Path | None:
    """Return where a stop stands in memory until its file is safe; None where there is no such folder."""
    folder = _folder_from_environment(_VOLATILE)
    if not folder.is_dir():
        return None
    return folder / f"gearbench-latch-{hashlib.sha256(str(latch.absolute()).encode()).hexdigest()[:16]}.json"


def _folder_from_environment(usual: Path) -> Path:
    given = os.environ.get(MACHINE)
    return Path(given) if given else usual


def _safe(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9._@-]", "_", name)


def state_root() -> Path:
    """Return the folder that holds the state folders of all benches; it need not be there yet."""
    given = os.environ.get(VARIABLE)
    if given:
        return Path(given)
    base = os.environ.get("XDG_STATE_HOME")
    return (Path(base) if base else Path.home() / ".local" / "state") / "gearbench"
