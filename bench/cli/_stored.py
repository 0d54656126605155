"""Results of a long command, kept in a file that it goes on from: JSON, a line a campaign."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.whole import write_whole

ROWS = "campaigns"
"""key of the rows that have a line each"""


def load_stored(path: Path | None, empty: Mapping[str, Any], same: tuple[str, ...] = ("format",)) -> dict[str, Any]:
    """What ``path`` holds; ``empty`` where there is no file, or no path.

    ``same``: keys of ``empty`` whose values the file has to have. Raises BenchError for any other file.
    """
    if path is None or not path.exists():
        return dict(empty)
    try:
        content: dict[str, Any] = json.loads(path.read_text("utf-8"))
    except ValueError as error:
        raise BenchError(f"{path}: is no JSON ({error}); --store should name a result of this command.") from error
    if any(content.get(key) != empty[key] for key in same):
        raise BenchError(
            f"{path}: is no {' of '.join(str(empty[key]) for key in same)}; --store should name one, or a new file."
        )
    return content


def store(path: Path | None, content: Mapping[str, Any]) -> None:
    """Write ``content`` whole; nothing where there is no path."""
    if path is None:
        return
    head = json.dumps({key: value for key, value in content.items() if key != ROWS}, ensure_ascii=False)
    rows = ",\n".join(json.dumps(row, ensure_ascii=False) for row in content[ROWS])
    write_whole(path, f'{head[:-1]}, "{ROWS}": [\n{rows}\n]}}\n')
