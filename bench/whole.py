"""Small files that are written whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path


def write_whole(path: Path, text: str) -> None:
    """Write a file so that, after a kill, a power cut or on a full disk, the old one is there or the new one, whole.

    It is written beside its place, forced to the disk and given its name (fsync of the file and of its folder).

    Raises
    ------
    OSError
        The disk refuses it; what was there before is still there.
    """
    target = path.resolve()  # where a link leads, not in place of it
    if target.exists() and not target.is_file():
        target.write_text(text, encoding="utf-8")  # a pipe or a terminal
        return
    new = target.with_name(f".{target.name}.{os.getpid()}.new")
    try:
        with new.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(new, target)
    except OSError:
        new.unlink(missing_ok=True)
        raise
    folder = os.open(target.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
