"""A latch on disk: a stop is stored by other threads, for nobody who brings a bench to rest may wait for a file.

A stop goes to up to three places at once: the latch's own file, a file of the machine (another state folder does not
forget the stop), and a spare one in memory (``/dev/shm``), which is taken away when the others are safe. Of copies that
differ the one that asks for most acts holds, and a copy that is empty, half-written or otherwise unreadable is a stop.
"""

from __future__ import annotations

import json
import os
import threading
import time
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any

from bench.errors import LimitError
from bench.safety.latch import Act, Latch, Standing
from bench.safety.paths import spare_path

_LARGEST = 1 << 20
_AGAIN_S = 0.05
"""A file that is being written may look half-written for a moment: it is looked at once more."""
_SETTLE_S = 1.0

_held: dict[Path, Latch] = {}
"""Stops of this process that are not yet, or could not be, stored: they hold for every latch of the same file."""


class LatchFile:
    """A latch on disk, or in memory where there is no path.

    Parameters
    ----------
    path : of the latch.
    machine : a second file that belongs to the machine, whatever state folder is used; None for none.
    """

    def __init__(self, path: Path | None = None, machine: Path | None = None) -> None:
        self.path = None if path is None else path.absolute()
        self._machine = machine
        self._spare = None if self.path is None else spare_path(self.path)
        self._kept = Latch()
        self._lock = threading.Lock()
        self._writing: dict[Path, threading.Thread] = {}
        self._pending: dict[Path, int] = {}
        self._failed: dict[Path, str] = {}

    def read(self) -> Latch:
        """Return the latch; one that cannot be read counts as a stop, because nothing is known of it."""
        if self.path is None:
            return self._kept
        with self._lock:
            held = _held.get(self.path)
        if held is not None:
            return held
        return max(
            (_read(path) for path in self._places()), key=lambda latch: (latch.strictness, latch.cause != "UNKNOWN")
        )

    def write(self, latch: Latch) -> None:
        """Keep a latch: on the disk when this returns.

        Raises
        ------
        OSError
            If a place cannot be written; the stricter copy holds.
        """
        self._kept = latch
        if self.path is None:
            return
        write_durably(self.path, latch.as_dict())
        if self._machine is not None:
            _write_copy(self._machine, latch)
        if self._spare is not None:
            self._spare.unlink(missing_ok=True)
            _temporary_path(self._spare).unlink(missing_ok=True)
        with self._lock:
            _held.pop(self.path, None)
            self._failed.clear()

    def stopped(self, cause: str, text: str, at: datetime) -> None:
        """Latch a stop: it is in force when this returns, which does not wait for the disk; threads store it."""
        latch = self._kept = Latch().stopped(cause, text, at.isoformat(timespec="milliseconds"))
        if self.path is None:
            return
        with self._lock:
            _held[self.path] = latch
            self._failed.clear()
            for path in filter(None, (self._spare, self.path, self._machine)):
                before = self._writing.get(path)
                self._pending[path] = self._pending.get(path, 0) + 1
                thread = threading.Thread(
                    target=self._store, args=(path, latch, before), name=f"latch {path.name}", daemon=True
                )
                self._writing[path] = thread
                thread.start()

    def settle(self, timeout_s: float = _SETTLE_S) -> str | None:
        """Wait until a stop is stored, ``timeout_s`` at most; return a sentence if it is not."""
        deadline = time.monotonic() + timeout_s
        for thread in list(self._writing.values()):
            thread.join(max(0.0, deadline - time.monotonic()))
        with self._lock:
            failed = {**{path: "the disk does not answer" for path in self._pending}, **self._failed}
            spare = None if self._spare in failed else self._spare
        if not failed.keys() - {self._spare}:
            return None
        reasons = "; ".join(f"{path}: {reason}" for path, reason in failed.items())
        place = "in this process only" if spare is None else f"in this process and, until the power goes, in {spare}"
        return f"the stop could not be stored ({reasons}); it holds {place}"

    def act(self, act: Act, by: str) -> Latch:
        """Do an act (see :meth:`Latch.after`) and store the resulting latch.

        Raises
        ------
        LimitError
            If another act is due, or it cannot be stored: the latch stays as it was, or asks for more.
        """
        latch = self.read().after(act, by)
        try:
            self.write(latch)
        except OSError as error:
            raise LimitError(f"the act cannot be stored ({error}): the bench stays stopped") from error
        return latch

    def _places(self) -> tuple[Path, ...]:
        finals = tuple(filter(None, (self.path, self._machine, self._spare)))
        return (*finals, *(_temporary_path(path) for path in finals))

    def _store(self, path: Path, latch: Latch, before: threading.Thread | None) -> None:
        """Store a stop in one place, after an earlier one that is still on its way there."""
        if before is not None:
            before.join()
        reason = ""
        try:
            write_durably(path, latch.as_dict())
        except OSError as error:
            reason = str(error)
        with self._lock:
            self._pending[path] -= 1
            if not self._pending[path]:
                del self._pending[path]
            if reason:
                self._failed[path] = reason
            if self.path is None or self._pending or self._failed.keys() - {self._spare}:
                return
            if _held.get(self.path) is latch:
                del _held[self.path]
        if self._spare is not None:
            with suppress(OSError):
                self._spare.unlink(missing_ok=True)


def _write_copy(path: Path, latch: Latch) -> None:
    """Write a copy of the latch; that of a bench which is free is removed."""
    if latch.standing is not Standing.CLEAR:
        write_durably(path, latch.as_dict())
        return
    path.unlink(missing_ok=True)
    _temporary_path(path).unlink(missing_ok=True)


def _read(path: Path) -> Latch:
    """Return the latch in a file; clear where there is none, stopped where it is unreadable."""
    for last in (False, True):
        try:
            return Latch.from_dict(json.loads(_content(path)))
        except FileNotFoundError:
            return Latch()
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
            if last:
                return Latch(Standing.STOPPED, "UNKNOWN", f"{path} cannot be read: {error}", "")
        time.sleep(_AGAIN_S)
    raise AssertionError("unreachable")


def _content(path: Path) -> bytes:
    """Return what is in a file; no link is followed and nothing waited for, since others may write in the folder."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        return os.read(descriptor, _LARGEST)
    finally:
        os.close(descriptor)


def _temporary_path(path: Path) -> Path:
    """Return where a file is written before it gets its name."""
    return path.with_name(path.name + ".new")


def write_durably(path: Path, content: dict[str, Any]) -> None:
    """Write JSON so that after a power cut either the old file or the new one is there, whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = _temporary_path(path)
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW | os.O_CLOEXEC
    with open(os.open(beside, flags, 0o644), "w", encoding="utf-8") as file:
        json.dump(content, file, indent=1, ensure_ascii=False)
        file.flush()
        os.fsync(file.fileno())
    beside.replace(path)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
