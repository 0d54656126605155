"""``bench benchmark opening``: how long a run and a reset take to begin on an emulated bench."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say


def opening(
    rounds: Annotated[int, typer.Option(min=1, help="How often the service is started.")] = 5,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Ask a service for runs and resets of an emulated bench; print how long each takes, as medians.

    A run is at the clock's pace. Each round takes about half a minute.
    """
    from bench.matrix.opening_times import measure_opening

    with tempfile.TemporaryDirectory(prefix="bench-opening-", ignore_cleanup_errors=True) as folder:
        found = measure_opening(
            rounds, Path(folder), report_progress=lambda text: None if as_json else say(f"{text} …")
        )
    if as_json:
        say(json.dumps(found.as_dict()))
        return
    for wait in found.waits:
        say(
            f"{wait.name} after {wait.median_s:.2f} s ({min(wait.wall_s):.2f} to {max(wait.wall_s):.2f} s,"
            f" processor time {wait.median_cpu_s:.2f} s)"
        )
    say(f"medians of {rounds} rounds ({found.processors} processors, load average {found.load:.1f})")
