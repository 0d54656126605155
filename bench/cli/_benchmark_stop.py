"""``bench benchmark stop``: how long STOP takes, however it is pressed and whatever is broken beside it."""

from __future__ import annotations

import json
import os
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say
from bench.cli.exit_codes import ExitCode


def stop(
    only: Annotated[
        list[str] | None, typer.Option("--only", help="Rows whose name holds this; may be given again. Default: all.")
    ] = None,
    table: Annotated[Path | None, typer.Option("--table", help="Write the table as a page of Markdown.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print every row as JSON.")] = False,
) -> None:
    """Press STOP on a bench that turns under load: on the page, in a second browser, in a shell; with service, run or
    disk broken. Exit code 6 if a press did not take the torque away within 0.2 s of the rung that says so.

    Needs root rights: it makes a veth pair, and disks that it fills, freezes and makes read-only.
    """
    from bench.matrix import stop_times
    from bench.matrix.stop_scene import CONDITIONS, PRESSES
    from bench.matrix.stop_table import page, reason
    from bench.proof.results import commit

    rows = []
    for condition in CONDITIONS:
        for press in PRESSES:
            name = f"{condition}, {press}"
            if only and not any(word in name for word in only):
                continue
            with tempfile.TemporaryDirectory(prefix="stop-", ignore_cleanup_errors=True) as folder:
                row = stop_times.measure(condition, press, Path(folder))
            rows.append(row)
            if table is not None:
                # after every row: what was measured stays if somebody ends it
                load = f"its load (five minutes) {os.getloadavg()[1]:.1f}"
                made = f"{datetime.now(UTC).date()}, commit {commit() or 'unknown'}"
                nice = f"; all its programs at nice {os.nice(0)}" if os.nice(0) else ""
                note = f"Rows are of {made}, measured on a machine of {os.cpu_count()} cores, {load}{nice}."
                table.write_text(page(rows, stop_times.WATCH_S, [note]), "utf-8")
            if not as_json:
                off = "no time seen" if row.torque_off_s is None else f"torque off after {row.torque_off_s:.2f} s"
                say(f"{name:38} {off:26} {row.note or row.told}")
    if as_json:
        say(json.dumps([row.as_dict() for row in rows], ensure_ascii=False))
    if any(reason(row) is not None for row in rows):
        raise typer.Exit(ExitCode.NOT_VALID)
