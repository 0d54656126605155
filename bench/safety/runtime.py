"""The folder of what lives as long as a process does: sockets of runs, locks, addresses. One function gives it.

Whoever can write there, or chose where it leads, could have a run of root truncate a file of their choice. So the
folder belongs to the user of this process, nobody else may enter it, and it is never reached through a link.
"""

from __future__ import annotations

import os
import stat
import tempfile
from pathlib import Path

from bench.errors import DeviceError

RUNTIME = "BENCH_RUNTIME"
"""Environment variable: the folder; default a folder of this user's below the temporary one."""
_OTHERS = 0o077
SOCKET_BYTES = 107
"""How long the path of a Unix socket may be on Linux (``sun_path`` without the zero at its end, unix(7))."""


def runtime_folder() -> Path:
    """Return the runtime folder, made (0700) if it is not there.

    Raises
    ------
    DeviceError
        If it is a link or no folder, belongs to somebody else, or others may enter the one that was given.
    """
    given = os.environ.get(RUNTIME)
    folder = Path(given) if given else Path(tempfile.gettempdir()) / f"gearbench-{os.geteuid()}"
    try:
        descriptor = _open_folder(folder)
    except (FileExistsError, NotADirectoryError) as error:
        raise _unusable_folder_error(folder, "is a link or no folder") from error
    except OSError as error:
        raise _unusable_folder_error(folder, f"cannot be opened ({error.strerror})") from error
    try:
        found = os.fstat(descriptor)
        if found.st_uid != os.geteuid():
            raise _unusable_folder_error(folder, f"belongs to user {found.st_uid}")
        if stat.S_IMODE(found.st_mode) & _OTHERS:
            if given:
                # not changed unasked: it may be a folder that others need, such as the temporary one
                raise _unusable_folder_error(folder, "can be entered by other users (it needs mode 0700)")
            os.fchmod(descriptor, 0o700)
    finally:
        os.close(descriptor)
    return folder


def socket_path(name: str) -> Path:
    """Return the path of a Unix socket of this name in the runtime folder.

    Raises
    ------
    DeviceError
        As :func:`runtime_folder`, or if the path would be longer than a socket's may be.
    """
    folder = runtime_folder()
    size, most = len(os.fsencode(folder)), SOCKET_BYTES - len(os.sep) - len(os.fsencode(name))
    if size > most:
        raise DeviceError(
            f"the path of the runtime folder {folder} has {size} bytes, for sockets of runs in it at most {most} would "
            f"be right; name a folder with a shorter path with {RUNTIME}"
        )
    return folder / name


def _open_folder(folder: Path) -> int:
    """Open a folder, made only if it is not there: on a disk that is frozen even a mkdir of what is there waits."""
    flags = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW
    try:
        return os.open(folder, flags)
    except FileNotFoundError:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        return os.open(folder, flags)


def open_here(path: Path) -> int:
    """Open a file of the runtime folder for reading and writing, made (0600) if it is not there; a link is refused."""
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)


def _unusable_folder_error(folder: Path, why: str) -> DeviceError:
    return DeviceError(
        f"the runtime folder {folder} {why} and is not used; remove it, or name a folder of your own with {RUNTIME}"
    )
