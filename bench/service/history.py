"""Live values kept for pages that are opened later: a fine ring and a coarse one, so that ten hours cost what ten
minutes do.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Any

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
    """Bounded memory of one run's live values."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget: a new run begins, whose bench time may be another."""
        self._fine: deque[Bucket] = deque(maxlen=FINE)
        self._coarse: deque[Bucket] = deque(maxlen=COARSE)
        self._open: list[Bucket] = []

    def add(self, bucket: Bucket) -> None:
        """Take a ``live`` message."""
        self._fine.append(bucket)
        self._open.append(bucket)
        if bucket["end"] - self._open[0]["start"] >= COARSE_S:
            self._coarse.append(merge(self._open))
            self._open.clear()

    def fine(self) -> list[Bucket]:
        """The last minutes."""
        return list(self._fine)

    def coarse(self) -> list[Bucket]:
        """The last hours, up to now."""
        return [*self._coarse, *([merge(self._open)] if self._open else [])]
