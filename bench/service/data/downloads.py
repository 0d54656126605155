"""Recordings on their way out: a folder as a tar archive in pieces, a recording exported in a process of its own."""

from __future__ import annotations

import asyncio
import shutil
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from datetime import datetime, timedelta
from pathlib import Path
from urllib.parse import quote

from bench.errors import ConfigurationError, RecordingError

_PIECE = 1 << 18
_AT_ONCE = 2


def tar(folder: Path) -> Iterator[bytes]:
    """Give a folder as a tar archive (POSIX.1-2001), piece by piece: its files, no links, nothing below it.

    A file that grows meanwhile is cut at the length it had; one that shrinks is filled with zeros to that length.
    """
    for path in sorted(folder.iterdir()):
        if path.is_symlink() or not path.is_file():
            continue
        with path.open("rb") as file:
            info = tarfile.TarInfo(f"{folder.name}/{path.name}")
            stamp = path.stat()
            info.size, info.mtime, info.mode = stamp.st_size, int(stamp.st_mtime), 0o644
            yield info.tobuf(tarfile.PAX_FORMAT)
            left = info.size
            while left:
                piece = file.read(min(_PIECE, left)) or bytes(min(_PIECE, left))
                left -= len(piece)
                yield piece
            yield bytes(-info.size % tarfile.BLOCKSIZE)
    yield bytes(2 * tarfile.BLOCKSIZE)


def attached(name: str) -> dict[str, str]:
    """Headers that have a browser save an answer under a name."""
    return {"Content-Disposition": f"attachment; filename*=UTF-8''{quote(name)}"}


def recording(path: Path) -> Path:
    """Return the path of a finished recording.

    Raises
    ------
    RecordingError
        If the file is none by its name.
    """
    if path.suffix not in (".h5", ".hdf5"):
        raise RecordingError(f'"{path.name}" is no recording; the folder can be downloaded as a whole')
    return path


def moment(text: str, is_end: bool) -> float | None:
    """Return a date or time as Unix time in s, None for an empty text; the end of a date is that of its day.

    Raises
    ------
    ConfigurationError
        If it is neither.
    """
    if not text.strip():
        return None
    try:
        found = datetime.fromisoformat(text.strip())
        whole_day = len(text.strip()) <= len("2026-11-22")
        return (found + timedelta(days=1) if is_end and whole_day else found).timestamp()
    except (ValueError, OverflowError, OSError):
        raise ConfigurationError(f'"{text}" is no date; write it as 2026-11-22, or 2026-11-22T14:30') from None


def remove(folder: Path) -> None:
    """Take a folder of a download away that was made for it."""
    shutil.rmtree(folder, ignore_errors=True)


class Exports:
    """Exports recordings with ``bench export`` at low priority, so many at once: the web process does nothing else."""

    def __init__(self) -> None:
        self._free = asyncio.Semaphore(_AT_ONCE)

    async def __call__(self, path: Path, form: str) -> Path:
        """Return the file made of a recording, alone in a folder that the caller removes.

        Raises
        ------
        RecordingError
            With what the export said.
        """
        folder = Path(tempfile.mkdtemp(prefix="bench-export-"))
        words = ["-c", "import os; os.nice(10); from bench.cli import main; main()", "export", str(path)]
        async with self._free:
            process = await asyncio.create_subprocess_exec(
                sys.executable,
                *words,
                "--to",
                form,
                "--out",
                str(folder),
                stdin=asyncio.subprocess.DEVNULL,
                stdout=asyncio.subprocess.DEVNULL,
                stderr=asyncio.subprocess.PIPE,
            )
            try:
                _, said = await process.communicate()
            except asyncio.CancelledError:
                process.kill()
                await process.wait()
                remove(folder)
                raise
        made = [one for one in folder.iterdir() if one.is_file()]
        if process.returncode or len(made) != 1:
            remove(folder)
            why = " ".join(said.decode("utf-8", "replace").split()) or f"exit code {process.returncode}"
            raise RecordingError(f"{path.name} could not be exported: {why}")
        return made[0]
