"""``bench benchmark archive``: how fast recordings are found again."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say


def archive(
    recordings: Annotated[int, typer.Option(min=1, help="How many recordings are made and searched.")] = 10_000,
    out: Annotated[
        Path | None, typer.Option("--out", help="Keep them in this folder, and use what it has; default: remove them.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Make recordings, index them from nothing, and search them by every criterion; prints how long each took.

    Ten thousand take some 300 MB and a few minutes to make.
    """
    from bench.archive.benchmark import measure_archive

    with tempfile.TemporaryDirectory(prefix="bench-archive-") as folder:
        figures = measure_archive(
            out or Path(folder), recordings, report_progress=lambda text: None if as_json else say(text)
        )
    if as_json:
        say(json.dumps(figures.as_dict()))
        return
    say(
        f"{figures.recordings} recordings in {figures.folders} folders, indexed from nothing in {figures.index_s:.1f} s"
        f" ({figures.index_bytes / 1e6:.1f} MB)"
    )
    for name, median in figures.median_s.items():
        say(
            f"{name}: {figures.found[name]} found in {1e3 * median:.0f} ms, at most"
            f" {1e3 * figures.slowest_s[name]:.0f} ms"
        )
