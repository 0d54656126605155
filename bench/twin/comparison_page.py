"""The comparison before and since as a page of its own, and as data."""

from __future__ import annotations

import html
import json
from pathlib import Path

from bench.identification.comparison.compare import to_json
from bench.identification.report.page import STYLE, html_table
from bench.twin.comparison import BeforeSince, cells, not_judged
from bench.typeset import figure
from bench.whole import write_whole

HEADINGS = ("what", "before", "since", "± of the difference", "unit", "p", "changed")


def write_comparison(found: BeforeSince, folder: Path) -> Path:
    """Write ``report.html`` and ``comparison.json`` into ``folder``; the path of the page."""
    folder.mkdir(parents=True, exist_ok=True)
    content = {"folder": found.folder.name, "since": found.since, "recordings": list(found.recordings)}
    write_whole(folder / "comparison.json", json.dumps(content | {"changes": to_json(found.changes)}, indent=1))
    rows = [[c.what, *cells(c), figure(c.p_value, ".1e"), "yes" if c.changed else "no"] for c in found.changes]
    changed = rows[: len(found.changed)]
    left_open = not_judged(found.changes)
    title = f"Before and since: {html.escape(found.folder.name)}"
    parts = [
        f"<div class=verdict><p>{html.escape(found.sentence)}</p>",
        "<p>Over all quantities together at most one comparison in twenty calls anything changed where nothing is.</p>",
        f"<p>{html.escape(left_open)}.</p></div>" if left_open else "</div>",
        "<h2>Changed</h2>",
        html_table(HEADINGS, changed) if changed else "<p>Nothing.</p>",
        f"<details><summary>All quantities</summary>{html_table(HEADINGS, rows)}</details>",
    ]
    path = folder / "report.html"
    write_whole(
        path,
        f"<!doctype html><html lang=en><meta charset=utf-8><title>{title}</title><style>{STYLE}</style>"
        f"<meta name=viewport content='width=device-width,initial-scale=1'><h1>{title}</h1>{''.join(parts)}</html>",
    )
    return path
