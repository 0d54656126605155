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
    store: Annotated[
        Path | None,
        typer.Option(
            "--store", help="Keep rows in this file; those measured before are shown, and not measured again."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print every row as JSON.")] = False,
) -> None:
    """Press STOP on a bench that rotates under load: on the page, in a second browser, in a shell; with service, run or
    disk broken. Exit code 6 if a press did not take the torque away within 0.2 s of the rung that says so.

    Needs root rights: it makes a veth pair, and disks that it fills, freezes and makes read-only.
    """
    from bench.matrix import stop_times
    from bench.matrix.stop_scene import CONDITIONS, PRESSES
    from bench.matrix.stop_table import page, reason
    from bench.matrix.stop_times import Row
    from bench.proof.results import commit

    before = [] if store is None or not store.exists() else json.loads(store.read_text("utf-8"))
    known = {(row.condition, row.press): row for row in (Row.of(entry) for entry in before)}
    pairs = [(condition, press) for condition in CONDITIONS for press in PRESSES]
    nice = f", programs at nice {os.nice(0)}" if os.nice(0) else ""
    made = f"{datetime.now(UTC).date()}, commit {commit() or 'unknown'}, {os.cpu_count()} processors{nice}"
    struck = []
    for condition, press in pairs:
        name, row = f"{condition}, {press}", known.get((condition, press))
        if (only and not any(word in name for word in only)) or (row is not None and not row.note):
            continue
        with tempfile.TemporaryDirectory(prefix="stop-", ignore_cleanup_errors=True) as folder:
            row = stop_times.measure(condition, press, Path(folder))
        row.made, row.load = made, os.getloadavg()[1]
        known[condition, press] = row
        struck.append(row)
        # after every row: what was measured stays if somebody ends it
        shown = [known[pair] for pair in pairs if pair in known]
        if store is not None:
            store.write_text(json.dumps([one.as_dict() for one in shown], ensure_ascii=False, indent=1) + "\n", "utf-8")
        if not as_json:
            off = "no time seen" if row.torque_off_s is None else f"torque off after {row.torque_off_s:.2f} s"
            say(f"{name:38} {off:26} {row.note or row.answer}")
    shown = [known[pair] for pair in pairs if pair in known]
    if table is not None:
        table.write_text(page(shown, stop_times.WATCH_S), "utf-8")
    if as_json:
        say(json.dumps([row.as_dict() for row in struck], ensure_ascii=False))
    if any(reason(row) is not None for row in shown):
        raise typer.Exit(ExitCode.NOT_VALID)
