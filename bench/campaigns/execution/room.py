"""Whether the disk takes another point, and the error for a run that had to end because it does not."""

from __future__ import annotations

import shutil
from pathlib import Path

from bench.errors import LimitError, RecordingError


class NoRoom(LimitError):
    """The disk takes no further point.

    Attributes
    ----------
    cause : name of the cause, for the alarm.
    """

    cause = "DISK"


def shortage(folder: Path, needed: float) -> str | None:
    """Return the sentence for a disk with less than ``needed`` bytes left, None if there is enough."""
    free = shutil.disk_usage(folder).free
    if free >= needed:
        return None
    return f"{folder} has {free / 1e6:.0f} MB of disk left, storage.minimum_free = {needed / 1e6:.0f} MB"


class NotWritten(RecordingError):
    """The disk refused the beginning of a recording; nothing has moved for it."""
