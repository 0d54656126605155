"""Records of the stops of a run, as JSON files in its folder: ``stop-0001.json`` and so on, never overwritten."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bench.safety import StopRecord
from bench.safety.latch_file import write_durably

PATTERN = "stop-*.json"


class StopLog:
    """Writes every stop of a rig once.

    Attributes
    ----------
    trouble : why the last one could not be written, else None; it is tried again with the next write.
    last : name of the file of the last stop; None where there was none, or its file could not be written.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._written = 0
        self.trouble: str | None = None
        self.last: str | None = None

    def write(self, stops: Sequence[StopRecord], recording: str = "") -> None:
        """Write those that are new; ``recording`` is the one in which they fell, empty outside of any."""
        for stop in stops[self._written :]:
            numbers = (path.stem.removeprefix("stop-") for path in self._folder.glob(PATTERN))
            # a file of another's making may match the pattern as well
            number = 1 + max((int(text) for text in numbers if text.isascii() and text.isdigit()), default=0)
            name = f"stop-{number:04d}.json"
            try:
                write_durably(self._folder / name, {**stop.as_dict(), "recording": recording})
            except OSError as error:
                # a full disk must not keep the recording from being closed
                self.trouble, self.last = f"the record of a stop could not be written: {error}", None
                return
            self._written += 1
            self.last = name
        self.trouble = None
