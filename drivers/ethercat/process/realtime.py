"""Ask the kernel for undisturbed cycles, and say plainly what was not granted."""

from __future__ import annotations

import ctypes
import gc
import os
from pathlib import Path

from drivers.ethercat.process.settings import RealTime

_LOCK_ALL = 1 | 2
"""mlockall: present and future pages."""


def isolated_cpus(text: str | None = None) -> tuple[int, ...]:
    """Return the processors the kernel keeps other work away from (``isolcpus``), ascending."""
    if text is None:
        path = Path("/sys/devices/system/cpu/isolated")
        text = path.read_text() if path.exists() else ""
    found: set[int] = set()
    for part in filter(None, text.strip().split(",")):
        first, _, last = part.partition("-")
        found.update(range(int(first), int(last or first) + 1))
    return tuple(sorted(found))


def become_real_time(wanted: RealTime) -> tuple[str, ...]:
    """Pin, raise and lock this process; one sentence for each thing that is not as asked for."""
    missing = [*_pin(wanted.cpu), *_raise(wanted.priority), *(_lock() if wanted.lock_memory else ())]
    gc.collect()
    gc.freeze()
    gc.disable()
    return tuple(missing)


def _pin(cpu: int | None) -> tuple[str, ...]:
    isolated = isolated_cpus()
    chosen = cpu if cpu is not None else (isolated[-1] if isolated else None)
    if chosen is None:
        return ()
    try:
        os.sched_setaffinity(0, {chosen})
    except OSError as error:
        return (f"the bus process could not be pinned to processor {chosen}: {error.strerror}",)
    return ()


def _raise(priority: int | None) -> tuple[str, ...]:
    if priority is None:
        return ("the bus process runs without real-time scheduling, as it was asked to: cycles may come late",)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except PermissionError:
        return (
            f"the bus process did not get SCHED_FIFO priority {priority} and runs slower, cycles may come late:"
            " CAP_SYS_NICE or an rtprio limit is needed",
        )
    return ()


def _lock() -> tuple[str, ...]:
    library = ctypes.CDLL(None, use_errno=True)
    if library.mlockall(_LOCK_ALL) != 0:
        reason = os.strerror(ctypes.get_errno())
        return (f"the bus process could not lock its memory ({reason}): CAP_IPC_LOCK or a memlock limit is needed",)
    return ()
