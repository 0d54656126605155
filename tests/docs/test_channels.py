"""The table of channels in docs/recordings.md is that of the program."""

from __future__ import annotations

from pathlib import Path

from bench.signals import SIGNALS

PAGE = Path(__file__).parents[2] / "docs" / "recordings.md"


def test_the_page_lists_every_channel_and_no_other() -> None:
    part = PAGE.read_text(encoding="utf-8").split("## Channels\n")[1].split("\n## ")[0]
    rows = [line for line in part.splitlines() if line.startswith("| `")]
    assert rows == [f"| `{s.name}` | {s.unit} | {s.presence.value} | {s.description} |" for s in SIGNALS]
