"""Where recordings lie, how much room is left, and how they are backed up."""

from __future__ import annotations

import shutil
import socket
from pathlib import Path
from typing import Any

BYTES_PER_SECOND = 2000 * 8.0
"""A second of recording at 2 kHz on the disk, compressed: 7 to 8 bytes a row (docs/recordings.md)."""


def storage(folder: Path, minimum_free: float) -> dict[str, Any]:
    """Return free space in bytes and hours of recording, and the command that copies everything elsewhere.

    ``minimum_free`` is what a run leaves free, bytes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    usage = shutil.disk_usage(folder)
    room = max(0.0, usage.free - minimum_free)
    return {
        "folder": str(folder.absolute()),
        "free_bytes": usage.free,
        "total_bytes": usage.total,
        "minimum_free_bytes": minimum_free,
        "hours": room / BYTES_PER_SECOND / 3600.0,
        "enough": usage.free > 2.0 * minimum_free,
        "backup": f"rsync -a --partial {socket.gethostname()}:{folder.absolute()}/ BACKUP/",
        "backup_note": "Finished recordings never change, so the copy may be made any time, also while a run goes on.",
    }
