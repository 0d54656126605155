"""Where what must outlive a run is kept: latch, commissioning record, lock of a bench on a network interface.

A bench that is emulated in the program's own process ends with it; its latch stands in the folder of the run. One
behind a network interface stays powered, whoever comes next, so its state belongs to the bench: a folder of its own
under ``$BENCH_STATE``, else ``$XDG_STATE_HOME/gearbench``, else ``~/.local/state/gearbench``.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from bench.configuration import BenchConfiguration

VARIABLE = "BENCH_STATE"
LATCH = "latch.json"


def state_folder(bench: BenchConfiguration) -> Path | None:
    """Return the folder of a bench behind a network interface, None for one in this process."""
    if bench.bus.in_process:
        return None
    name = re.sub(r"[^A-Za-z0-9._@-]", "_", f"{bench.name}@{bench.bus.interface}")
    return state_root() / name


def latch_path(bench: BenchConfiguration, run: Path) -> Path:
    """Return where the latch of a bench stands; ``run`` is the folder of the run."""
    return (state_folder(bench) or run) / LATCH


def state_root() -> Path:
    """Return the folder that holds the state folders of all benches; it need not be there yet."""
    given = os.environ.get(VARIABLE)
    if given:
        return Path(given)
    base = os.environ.get("XDG_STATE_HOME")
    return (Path(base) if base else Path.home() / ".local" / "state") / "gearbench"
