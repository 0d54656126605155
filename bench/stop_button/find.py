"""Find what runs on this computer: by the sockets of the stop listeners, else by the file that names one."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from bench.errors import BenchError
from bench.safety.runtime import RUNTIME, runtime_folder
from bench.stop_button.listener import FILE, NAME, runtime_tag

_SOCKETS = Path("/proc/net/unix")
_OURS = re.compile(rf"@({re.escape(NAME)}([0-9a-z]+)-(\d+)-[0-9a-f]+)$", re.MULTILINE)
_OURS_NAME = re.compile(rf"^{re.escape(NAME)}([0-9a-z]+)-.*$")
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
    only = runtime_tag() if os.environ.get(RUNTIME) else None
    sockets = _sockets(lambda tag: only in (None, tag))
    recorded = _recorded_pid()
    if recorded is not None:
        sockets.setdefault(recorded, [])
    return [Found(pid, tuple(names)) for pid, names in sockets.items() if is_alive(pid)]


def elsewhere() -> list[Found]:
    """Return the processes whose stop listener is there, but of another runtime folder than the one that is given.

    None are where no runtime folder is given (``BENCH_RUNTIME``): then :func:`runs` has them all.
    """
    if not os.environ.get(RUNTIME):
        return []
    own, known = runtime_tag(), {run.pid for run in runs()}
    sockets = _sockets(lambda tag: tag != own)
    return [Found(pid, tuple(names)) for pid, names in sockets.items() if pid not in known and is_alive(pid)]


def looked_at() -> str:
    """Return where :func:`runs` has looked, in words."""
    given = os.environ.get(RUNTIME)
    return f"the runtime folder {given} ({RUNTIME})" if given else "every runtime folder on this computer"


def how_to_stop(run: Found) -> str:
    """Return the sentence on a run of another runtime folder: which one, if it can be read, and how it is stopped."""
    who, folder = f"process {run.pid} runs a bench", _runtime_folder_of(run)
    if folder:
        return f"{who} with the runtime folder {folder}; stop it: {RUNTIME}={folder} bench stop"
    whose = "without a runtime folder of its own" if folder == "" else "with another runtime folder"
    return f"{who} {whose}; stop every run on this computer: env -u {RUNTIME} bench stop"


def _runtime_folder_of(run: Found) -> str | None:
    """Return the runtime folder of a run, empty for none; None where it cannot be told.

    The environment a process was started with counts only if it agrees with the tag in the name of the listener.
    """
    tags = {_OURS_NAME.sub(r"\1", name) for name in run.sockets}
    try:
        entries = Path(f"/proc/{run.pid}/environ").read_bytes().split(b"\0")
    except OSError:
        return None  # it has ended meanwhile, or belongs to another user
    begin = f"{RUNTIME}=".encode()
    given = (entry.removeprefix(begin) for entry in entries if entry.startswith(begin))
    folder = next(given, b"").decode("utf-8", "replace")
    return folder if tags == {runtime_tag(folder)} else None


def _sockets(counts: Callable[[str], bool]) -> dict[int, list[str]]:
    """Return the stop listeners whose tag ``counts``, by process: a name of each, however many connections it has."""
    sockets: dict[int, list[str]] = {}
    for name, tag, pid in _listeners():
        if counts(tag) and name not in sockets.setdefault(pid, []):
            sockets[pid].append(name)
    return sockets


def _listeners() -> list[tuple[str, str, int]]:
    """Return name, tag of the runtime folder and process id of every stop listener that the kernel lists."""
    try:
        listed = _SOCKETS.read_text("utf-8", "replace")
    except OSError:
        return []  # the file in the runtime folder, and a signal, are the other way to a run
    return [(name, tag, int(pid)) for name, tag, pid in _OURS.findall(listed)]


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
