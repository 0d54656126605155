"""Where things are, as CONTRIBUTING says: every path of its table is there."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PATH = re.compile(r"`((?:bench|fakes|drivers|sequences)/[\w/.]+)`")


def test_what_the_table_names_is_there() -> None:
    rows = [line for line in (ROOT / "CONTRIBUTING.md").read_text("utf-8").splitlines() if line.startswith("| ")]
    named = [path for row in rows for path in PATH.findall(row)]
    assert len(named) > 10
    assert [path for path in named if not (ROOT / path).exists()] == []
