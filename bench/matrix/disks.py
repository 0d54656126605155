"""Disks that can be filled, frozen or made read-only while something uses them; they need root rights."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from bench.errors import DeviceError

DISK_BYTES = 160 << 20
"""Room for a service's files and a minute of recording."""


@dataclass(frozen=True, slots=True)
class Disk:
    """A folder on a disk of its own, and what breaks and mends it."""

    folder: Path
    break_: Callable[[], None]
    mend: Callable[[], None]


@contextmanager
def disk(kind: str, folder: Path) -> Iterator[Disk]:
    """Give a disk that can be made ``full``, ``read-only`` or ``frozen``; an empty kind gives a plain folder.

    Raises
    ------
    DeviceError
        If it cannot be made here.
    """
    folder.mkdir(parents=True)
    if not kind:
        yield Disk(folder, lambda: None, lambda: None)
        return
    image = folder.with_name("image")
    with image.open("wb") as file:
        file.truncate(DISK_BYTES)
    _run_command("mkfs.ext4", "-q", "-F", "-m", "0", str(image))
    _run_command("mount", "-o", "loop", str(image), str(folder))
    filler = folder / "filler"

    def fill() -> None:
        with suppress(OSError), filler.open("wb", buffering=0) as file:
            while True:
                file.write(bytes(1 << 16))
        with suppress(OSError), filler.open("ab", buffering=0) as file:
            while True:
                file.write(b"\0")

    breaks: dict[str, tuple[Callable[[], None], Callable[[], None]]] = {
        "full": (fill, lambda: filler.unlink(missing_ok=True)),
        # a mount stays writable as long as a file is open for writing; nothing can be made or changed in these any more
        "read-only": (
            lambda: _run_command("chattr", "-R", "-f", "+i", *_entries(folder)),
            lambda: _run_command("chattr", "-R", "-f", "-i", *_entries(folder)),
        ),
        "frozen": (
            lambda: _run_command("fsfreeze", "--freeze", str(folder)),
            lambda: _run_command("fsfreeze", "--unfreeze", str(folder)),
        ),
    }
    break_, mend = breaks[kind]
    try:
        yield Disk(folder, break_, mend)
    finally:
        with suppress(DeviceError):
            mend()
        _run_command("umount", "-l", str(folder))


def _entries(folder: Path) -> list[str]:
    return [str(path) for path in folder.iterdir() if path.name != "lost+found"]


def _run_command(*command: str) -> None:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise DeviceError(f"{command[0]} cannot be used here: {error}") from error
    if done.returncode and command[0] != "chattr":
        # sockets have no such attribute, which chattr counts as a failure
        raise DeviceError(f"{' '.join(command[:4])}: {done.stderr.strip()}")
