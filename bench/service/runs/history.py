"""Live values kept for pages that are opened later: a fine ring and a coarse one, so that ten hours cost what ten
minutes do.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from bench.service.files.disk import Disk

FINE = 3300
"""Buckets as they come, some 0.2 s each: eleven minutes."""
COARSE = 4320
COARSE_S = 10.0
"""Merged buckets of at least ten seconds of bench time: twelve hours."""

Bucket = dict[str, Any]


def merge(buckets: Iterable[Bucket]) -> Bucket:
    """Return one bucket for several that follow each other: least minimum, greatest maximum, mean weighted by time."""
    parts = list(buckets)
    weights = [max(part["end"] - part["start"], 1e-9) for part in parts]
    total = sum(weights)
    values: dict[str, list[float]] = {}
    for name in parts[0]["values"]:
        rows = [part["values"][name] for part in parts if name in part["values"]]
        mean = sum(
            w * part["values"][name][2] for w, part in zip(weights, parts, strict=True) if name in part["values"]
        )
        values[name] = [min(row[0] for row in rows), max(row[1] for row in rows), mean / total, rows[-1][3]]
    return {**parts[-1], "start": parts[0]["start"], "end": parts[-1]["end"], "values": values}


class History:
    """Bounded memory of one run's live values; its hours are kept in a file, where it is given one."""

    def __init__(self) -> None:
        self._path: Path | None = None
        self._disk: Disk | None = None
        self.clear()

    def keep_in(self, path: Path, disk: Disk) -> None:
        """Write merged buckets into a file of the run from now on; nothing is read, and nothing is waited for."""
        self._path, self._disk = path, disk

    def take_up(self, path: Path, disk: Disk) -> None:
        """Go on with the file of a run that an earlier service wrote; a line that was cut, or is none, is left out."""
        self.keep_in(path, disk)
        try:
            lines = path.read_text("utf-8", "replace").splitlines()
        except OSError:
            return
        for line in lines[-COARSE:]:
            try:
                bucket = json.loads(line)
                merge([bucket, bucket])
            except (ValueError, KeyError, TypeError, IndexError, AttributeError):
                continue
            self._coarse.append(bucket)

    def clear(self) -> None:
        """Forget: a new run begins, whose bench time may be another."""
        self._path = None
        self._fine: deque[Bucket] = deque(maxlen=FINE)
        self._coarse: deque[Bucket] = deque(maxlen=COARSE)
        self._open: list[Bucket] = []

    def add(self, bucket: Bucket) -> None:
        """Take a ``live`` message."""
        self._fine.append(bucket)
        self._open.append(bucket)
        if bucket["end"] - self._open[0]["start"] >= COARSE_S:
            merged = merge(self._open)
            self._coarse.append(merged)
            self._open.clear()
            if self._path is not None and self._disk is not None:
                self._disk.append(self._path, json.dumps(merged))

    def fine(self) -> list[Bucket]:
        """The last minutes."""
        return list(self._fine)

    def coarse(self) -> list[Bucket]:
        """The last hours, up to now."""
        return [*self._coarse, *([merge(self._open)] if self._open else [])]
