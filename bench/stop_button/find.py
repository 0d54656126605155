"""Find what runs on this computer: by the sockets of the stop listeners, else by the file that names one."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass
from pathlib import Path

from bench.errors import BenchError
from bench.safety.runtime import RUNTIME, runtime_folder
from bench.stop_button.listener import FILE, NAME, runtime_tag

_SOCKETS = Path("/proc/net/unix")
_OURS = re.compile(rf"@({re.escape(NAME)}([0-9a-z]+)-(\d+)-[0-9a-f]+)$", re.MULTILINE)
_BUS_PROCESS = b"drivers.ethercat.process"


@dataclass(frozen=True, slots=True)
class Found:
    """A run: its process, and the abstract names of its listeners; none where only the file knows it."""

    pid: int
    sockets: tuple[str, ...]


def runs() -> list[Found]:
    """Return the processes that run a bench, those whose listener is known first.

    With a runtime folder given (``BENCH_RUNTIME``) only those that have it; else all on this computer.
    """
    sockets: dict[int, list[str]] = {}
    try:
        listed = _SOCKETS.read_text("utf-8", "replace")
    except OSError:
        listed = ""
    only = runtime_tag() if os.environ.get(RUNTIME) else None
    for name, tag, pid in _OURS.findall(listed):
        if only in (None, tag) and name not in sockets.setdefault(int(pid), []):
            sockets[int(pid)].append(name)
    recorded = _recorded_pid()
    if recorded is not None:
        sockets.setdefault(recorded, [])
    return [Found(pid, tuple(names)) for pid, names in sockets.items() if is_alive(pid)]


def is_alive(pid: int) -> bool:
    """Whether a process is there and not only waits to be buried."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (OSError, IndexError):
        return False


def bus_processes(run: int) -> list[int]:
    """Return the bus processes a run has started: they stop the drives by themselves when they are asked to end."""
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == run and _BUS_PROCESS in (entry / "cmdline").read_bytes():
                found.append(int(entry.name))
        except (OSError, IndexError, ValueError):
            continue  # it has ended meanwhile
    return found


def _recorded_pid() -> int | None:
    """Return the process the runtime folder names, if it is still the one that wrote it."""
    try:
        file = runtime_folder() / FILE
        pid = int(json.loads(file.read_text("utf-8"))["pid"])
        began = os.stat(f"/proc/{pid}").st_mtime
        return pid if began <= file.stat().st_mtime + 1.0 else None
    except (OSError, ValueError, KeyError, TypeError, BenchError):
        return None
