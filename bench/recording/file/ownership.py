"""Whose file is it: a recording in the making belongs to the process that writes it, and to nobody after a kill."""

from __future__ import annotations

import fcntl
import os
import struct
from pathlib import Path

from bench.errors import RecordingError

# struct flock of Linux: type, whence, start, length, pid. Open-file-description locks live and die with the descriptor
# of the writer and, other than flock(), do not meet the locks that HDF5 readers take.
_FLOCK = "hhxxxxqqixxxx"


def claim(descriptor: int) -> None:
    """Lock a file for as long as its descriptor is open.

    Raises
    ------
    BlockingIOError
        Another descriptor has it.
    """
    fcntl.fcntl(descriptor, fcntl.F_OFD_SETLK, struct.pack(_FLOCK, fcntl.F_WRLCK, os.SEEK_SET, 0, 0, 0))


def refuse_if_written(part: Path) -> None:
    """Raise a :class:`RecordingError` where a living process is still writing ``part``."""
    try:
        descriptor = os.open(part, os.O_RDWR)
    except OSError as error:
        raise RecordingError(f"{part}: cannot be opened for writing ({error.strerror}).") from error
    try:
        claim(descriptor)
    except BlockingIOError:
        raise RecordingError(f"{part}: is being written by a living process, it should be left alone.") from None
    finally:
        os.close(descriptor)


def make_room(part: Path) -> None:
    """Set aside an unfinished file of the same name: nothing that was recorded is overwritten."""
    if not part.exists():
        return
    refuse_if_written(part)
    number = 1
    while (aside := part.with_name(f"{part.name}.{number}{part.suffix}")).exists():
        number += 1
    part.rename(aside)
