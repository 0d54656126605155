"""Records of the stops of a run, as JSON files in its folder: ``stop-0001.json`` and so on, never overwritten."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bench.safety import StopRecord
from bench.safety.latch import write_durably

PATTERN = "stop-*.json"


class StopLog:
    """Writes every stop of a rig once."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._written = 0

    def write(self, stops: Sequence[StopRecord], recording: str = "") -> None:
        """Write those that are new; ``recording`` is the one in which they fell, empty outside of any."""
        for stop in stops[self._written :]:
            number = 1 + max((int(path.stem.removeprefix("stop-")) for path in self._folder.glob(PATTERN)), default=0)
            write_durably(self._folder / f"stop-{number:04d}.json", {**stop.as_dict(), "recording": recording})
            self._written += 1
