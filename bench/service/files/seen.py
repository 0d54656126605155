"""When the service was last seen alive: a file it writes every few seconds, read by the one that comes after it."""

from __future__ import annotations

from pathlib import Path

SEEN_EVERY_S = 10.0


def last_seen(path: Path) -> str:
    """Return in words when the service before this one wrote the file last."""
    try:
        at = path.read_text("utf-8").strip()[:40]
    except (OSError, UnicodeDecodeError):
        return "and nobody knows since when"
    return f"last seen at {at}" if at else "and nobody knows since when"
