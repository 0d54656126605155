"""The record book: every act of an operator and every alarm, one JSON line each, UTC, never changed afterwards."""

from __future__ import annotations

import json
import os
from collections import deque
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

_SHOWN = 200


class Book:
    """Appends entries to a file and keeps the last ones at hand."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._path = path
        self._last: deque[dict[str, Any]] = deque(maxlen=_SHOWN)
        if path.exists():
            with path.open(encoding="utf-8") as lines:
                for line in lines:
                    try:
                        self._last.append(json.loads(line))
                    except ValueError:
                        # the last line of a power cut; what it would have said is lost, the rest is not
                        continue

    def write(self, act: str, by: str, text: str, **more: Any) -> dict[str, Any]:
        """Append an entry; it is on the disk when this returns."""
        entry = {"at": datetime.now(UTC).isoformat(timespec="milliseconds"), "act": act, "by": by, "text": text, **more}
        descriptor = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o640)
        try:
            os.write(descriptor, json.dumps(entry, ensure_ascii=False).encode() + b"\n")
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
        self._last.append(entry)
        return entry

    def last(self) -> list[dict[str, Any]]:
        """The last entries, newest first."""
        return list(reversed(self._last))

    def last_of(self, act: str) -> dict[str, Any] | None:
        """The last entry of an act among those at hand, None if there is none."""
        return next((entry for entry in reversed(self._last) if entry["act"] == act), None)
