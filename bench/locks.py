"""Who has which bus: a lock while it is open, and the address of a service that takes runs for it."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from bench.configuration import BenchFile
from bench.errors import DeviceError
from bench.safety.runtime import open_here, runtime_folder

__all__ = ["bus_in_use", "bus_name", "folder_in_use", "service_for", "serving"]


def bus_name(file: BenchFile) -> str:
    """What two programs would fight for: the network interface, or for an emulated bench its own name."""
    bus = file.configuration.bus
    return (
        f"emulated-{file.configuration.name}" if bus.plant is not None and bus.master == "emulated" else bus.interface
    )


def _path(file: BenchFile, kind: str) -> Path:
    name = bus_name(file)
    safe = "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in name)
    return runtime_folder() / f"{kind}-{safe}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"


@contextmanager
def serving(file: BenchFile, address: dict[str, Any]) -> Iterator[None]:
    """Be the one service of this bus as long as the context lasts.

    Raises
    ------
    DeviceError
        If another service is.
    """
    with _file_lock(_path(file, "service"), {"pid": os.getpid(), **address}) as holder:
        if holder is not None:
            raise DeviceError(
                f"a service for {bus_name(file)} runs already: {holder.get('url', 'somewhere')}, process"
                f" {holder.get('pid', 'unknown')}"
            )
        yield


@contextmanager
def folder_in_use(state: Path, address: dict[str, Any]) -> Iterator[None]:
    """Be the one service that keeps its queue in a folder: two would begin each other's runs.

    Raises
    ------
    DeviceError
        If another service does.
    """
    state.mkdir(parents=True, exist_ok=True)
    with _file_lock(state / "lock", {"pid": os.getpid(), **address}) as holder:
        if holder is not None:
            raise DeviceError(
                f"the service at {holder.get('url', 'somewhere')} keeps its recordings in {state.parent} too; give this"
                " one a folder of its own with --folder"
            )
        yield


@contextmanager
def bus_in_use(file: BenchFile) -> Iterator[None]:
    """Have the bus to oneself as long as the context lasts; an emulated one in this process is nobody else's anyway.

    Raises
    ------
    DeviceError
        If another process has it.
    """
    if file.configuration.bus.in_process:
        yield
        return
    with _file_lock(_path(file, "bus"), {"pid": os.getpid()}) as holder:
        if holder is not None:
            raise DeviceError(
                f"the bus {bus_name(file)} is in use by process {holder.get('pid', 'unknown')}; wait for its end"
            )
        yield


def service_for(file: BenchFile) -> dict[str, Any] | None:
    """Return the address of the service that takes runs for this bus, None if there is none."""
    path = _path(file, "service")
    if not path.exists():
        return None
    with _file_lock(path, None) as holder:
        return holder


@contextmanager
def _file_lock(path: Path, content: dict[str, Any] | None) -> Iterator[dict[str, Any] | None]:
    """Lock a file and yield None, or yield what its holder wrote; ``content`` None only looks."""
    descriptor = open_here(path)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield _content(descriptor)
            return
        if content is not None:
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, json.dumps(content).encode(), 0)
        yield None
    finally:
        os.close(descriptor)


def _content(descriptor: int) -> dict[str, Any]:
    with suppress(ValueError):
        content = json.loads(os.pread(descriptor, 65536, 0))
        if isinstance(content, dict):
            return content
    return {}
