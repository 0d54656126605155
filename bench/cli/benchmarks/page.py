"""``bench benchmark page``: how fast the operator's page is, in real browsers."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say


def page(
    seconds: Annotated[float, typer.Option(min=2.0, help="How long values are watched.")] = 20.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Open four browsers on an emulated bench that measures at 2 kHz and the clock's pace; print how fast they are.

    Needs Chromium with its driver, and selenium. Run it beside `bench benchmark cycle` to see what it costs the cycle.
    """
    from bench.matrix.page_speed import measure_page

    with tempfile.TemporaryDirectory(prefix="bench-page-", ignore_cleanup_errors=True) as folder:
        found = measure_page(seconds, Path(folder), report_progress=lambda text: None if as_json else say(f"{text} …"))
    if as_json:
        say(json.dumps(found.as_dict()))
        return
    p95, longest, paint = (_text(value) for value in (found.value_p95_s, found.value_longest_s, found.paint_s))
    say(
        f"{found.pages} pages, {found.values} values in {found.seconds:g} s: a new one every {p95} (95th percentile),"
        f" {longest} at most\n"
        f"{found.frames_per_s:.0f} frames/s while an hour is panned; first paint after {paint} at most\n"
        f"the service takes {100 * found.service_share:.1f} % of one processor"
        f" ({found.processors} processors, load average {found.load:.1f})"
    )


def _text(seconds: float | None) -> str:
    return "not seen" if seconds is None else f"{seconds:.2f} s"
