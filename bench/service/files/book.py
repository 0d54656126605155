"""The record book: every act of an operator and every alarm, one JSON line each, never changed afterwards.

Times are local with their offset to UTC, so that they read as the clock on the wall and are unambiguous.
"""

from __future__ import annotations

import json
from collections import deque
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from bench.service.files.disk import Disk

_SHOWN = 200


def local_time(moment: datetime | None = None) -> str:
    """ISO 8601 with milliseconds and the offset of this computer's zone; now, if no moment is given."""
    return (moment or datetime.now()).astimezone().isoformat(timespec="milliseconds")


def local_time_of(moment_ns: int) -> str:
    """A Unix time in ns as local time with its offset to UTC."""
    return local_time(datetime.fromtimestamp(moment_ns / 1e9, UTC))


class Book:
    """Appends entries to a file and keeps the last ones at hand. Never waits for the disk, and never fails for it."""

    def __init__(self, path: Path, disk: Disk) -> None:
        self._path, self._disk = path, disk
        self._last: deque[dict[str, Any]] = deque(maxlen=_SHOWN)
        try:
            with path.open(encoding="utf-8", errors="replace") as lines:
                for line in lines:
                    self._take(line)
        except FileNotFoundError:
            pass
        except OSError as error:
            self._last.append(_entry("service", "service", f"the book so far cannot be read: {error}"))

    def write(self, act: str, by: str, text: str, **more: Any) -> dict[str, Any]:
        """Append an entry; it is at hand when this returns, and soon on the disk."""
        entry = _entry(act, by, text, **more)
        self._last.append(entry)
        self._disk.append(self._path, json.dumps(entry, ensure_ascii=False))
        return entry

    def last(self) -> list[dict[str, Any]]:
        """The last entries, newest first."""
        return list(reversed(self._last))

    def find(self, words: str = "", act: str = "", limit: int = _SHOWN) -> list[dict[str, Any]]:
        """Return entries of the whole book, newest first; each word stands somewhere in an entry, ``act`` is its act.

        It reads the file, and may take as long as the disk does; what is not on the disk yet is there all the same.
        """
        try:
            lines = self._path.read_text("utf-8", "replace").splitlines()
        except FileNotFoundError:
            lines = []
        kept = [entry for entry in map(_read, lines) if entry is not None]
        known = {json.dumps(entry, sort_keys=True) for entry in kept[-2 * _SHOWN :]}
        kept += [entry for entry in self._last if json.dumps(entry, sort_keys=True) not in known]
        wanted = words.lower().split()

        def fits(entry: dict[str, Any]) -> bool:
            text = " ".join(str(value) for value in entry.values()).lower()
            return act in ("", entry["act"]) and all(word in text for word in wanted)

        return [entry for entry in reversed(kept) if fits(entry)][:limit]

    def last_of(self, act: str) -> dict[str, Any] | None:
        """The last entry of an act among those at hand, None if there is none."""
        return next((entry for entry in reversed(self._last) if entry["act"] == act), None)

    def _take(self, line: str) -> None:
        entry = _read(line)
        if entry is not None:
            self._last.append(entry)


def _read(line: str) -> dict[str, Any] | None:
    """An entry, None for a line that is none: the last one of a power cut; the rest is not lost with it."""
    try:
        entry = json.loads(line)
    except ValueError:
        return None
    return entry if isinstance(entry, dict) and {"at", "act", "by", "text"} <= entry.keys() else None


def _entry(act: str, by: str, text: str, **more: Any) -> dict[str, Any]:
    return {"at": local_time(), "act": act, "by": by, "text": text, **more}
