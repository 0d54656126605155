"""Where an imported recording comes from, as its header says it."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any


def provenance(file: Path, rows: slice, number: int, count: int) -> dict[str, Any]:
    """The attributes of a recording that say of which file, and of which of its rows, it was made."""
    attributes: dict[str, Any] = {"imported_from": file.name}
    if count > 1:
        attributes |= {"piece": f"{number} of {count}", "first_row": int(rows.start), "rows_end": int(rows.stop)}
    return attributes


def software() -> dict[str, str]:
    """The program that imports, as a header has it."""
    try:
        release = version("gearbench")
    except PackageNotFoundError:
        release = "unknown"
    return {"name": "gearbench", "version": release, "revision": "unknown"}
