"""Outcomes in a file, so that a page can be made anew from some rows that were run and others that were not."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from bench.matrix.outcome import Outcome
from bench.matrix.rows import Row


def load(path: Path) -> list[Outcome]:
    """Return the outcomes of a file, none where there is no file; raises KeyError or ValueError if it is another's."""
    if not path.exists():
        return []
    return [Outcome.of(content) for content in json.loads(path.read_text("utf-8"))]


def save(path: Path, outcomes: Sequence[Outcome]) -> None:
    """Write outcomes."""
    content = [outcome.as_dict() for outcome in outcomes]
    path.write_text(json.dumps(content, ensure_ascii=False, indent=1) + "\n", "utf-8")


def newest_outcomes(old: Sequence[Outcome], new: Sequence[Outcome], rows: Sequence[Row]) -> list[Outcome]:
    """Return the newest outcome of each row there is, in the rows' order; rows never run are left out."""
    known = {(outcome.name, outcome.text): outcome for outcome in (*old, *new)}
    keys = [(row.name, row.text) for row in rows]
    return [known[key] for key in keys if key in known]
