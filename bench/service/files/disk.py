"""The service's own files, written by a thread of their own: whoever hands something to it never waits for a disk.

What could not be written is kept and tried again; of a file that is replaced only the newest content counts.
"""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path

RETRY_S = 1.0
SLOW_S = 2.0
"""A write that takes so long is said: the disk is frozen or overloaded."""
_MOST_LINES = 10_000
"""So many lines of the book wait for a disk that takes none; then the oldest are given up."""


class _Lines:
    """Lines still to be appended to a file."""

    def __init__(self, lines: list[bytes], torn: bool = False) -> None:
        self.lines, self.torn = lines, torn

    def and_then(self, later: _Lines | _Content) -> _Lines | _Content:
        if isinstance(later, _Content):
            return later
        return _Lines((self.lines + later.lines)[-_MOST_LINES:], self.torn)

    def write(self, path: Path) -> None:
        descriptor = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o640)
        try:
            # after a write that was cut off, the next line begins a line of its own
            data = (b"\n" if self.torn else b"") + b"".join(self.lines)
            self.torn = True
            while data:
                data = data[os.write(descriptor, data) :]
            os.fsync(descriptor)
            self.torn = False
        finally:
            os.close(descriptor)


class _Content:
    """New content of a file; None takes it away."""

    def __init__(self, content: bytes | None) -> None:
        self._content = content

    def and_then(self, later: _Lines | _Content) -> _Lines | _Content:
        return later

    def write(self, path: Path) -> None:
        if self._content is None:
            path.unlink(missing_ok=True)
            return
        part = path.with_name(path.name + ".part")
        descriptor = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o640)
        try:
            data = self._content
            while data:
                data = data[os.write(descriptor, data) :]
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
        os.replace(part, path)


class Disk:
    """Writes files one after the other; usable from any thread, and none of its methods but ``settled`` waits."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._waiting: dict[Path, _Lines | _Content] = {}
        self._failed: dict[Path, str] = {}
        self._busy: tuple[Path, float] | None = None
        self._ended = False
        threading.Thread(target=self._work, name="disk", daemon=True).start()

    def replace(self, path: Path, text: str) -> None:
        """Give a file this content, whole or not at all."""
        self._enqueue(path, _Content(text.encode()))

    def remove(self, path: Path) -> None:
        """Take a file away; nothing if there is none."""
        self._enqueue(path, _Content(None))

    def append(self, path: Path, line: str) -> None:
        """Append a line."""
        self._enqueue(path, _Lines([line.encode("utf-8", "replace") + b"\n"]))

    @property
    def trouble(self) -> str | None:
        """What keeps files from being written, in one sentence; None if all is well."""
        with self._changed:
            if self._busy is not None and time.monotonic() - self._busy[1] > SLOW_S:
                return f"{self._busy[0].parent} takes no data for more than {SLOW_S:.0f} s"
            return next(iter(self._failed.values()), None)

    def settled(self, limit_s: float) -> bool:
        """Wait until everything is written, at most so long; False if it is not."""
        with self._changed:
            return self._changed.wait_for(lambda: not self._waiting and self._busy is None, limit_s)

    def close(self, limit_s: float) -> bool:
        """Write what waits, at most so long, then end; False if something was not written."""
        done = self.settled(limit_s)
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        return done

    def _enqueue(self, path: Path, job: _Lines | _Content) -> None:
        with self._changed:
            earlier = self._waiting.get(path)
            self._waiting[path] = job if earlier is None else earlier.and_then(job)
            self._changed.notify_all()

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._ended)
                if self._ended:
                    return
                path, job = next(iter(self._waiting.items()))
                del self._waiting[path]
                self._busy = (path, time.monotonic())
            why = _write_job(path, job)
            with self._changed:
                self._busy = None
                if why is None:
                    self._failed.pop(path, None)
                else:
                    self._failed[path] = why
                    later = self._waiting.pop(path, None)
                    # at the end, so that other files get their turn
                    self._waiting[path] = job if later is None else job.and_then(later)
                self._changed.notify_all()
                if why is not None:
                    self._changed.wait_for(lambda: self._ended, RETRY_S)


def _write_job(path: Path, job: _Lines | _Content) -> str | None:
    """Write; return why it could not be done, None if it is."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        job.write(path)
    except OSError as error:
        return f"{path} cannot be written: {error.strerror or error}"
    return None
