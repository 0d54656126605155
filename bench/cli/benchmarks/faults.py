"""``bench benchmark faults``: everything that can break, broken, and what then happens."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say
from bench.cli.exit_codes import ExitCode


def faults(
    only: Annotated[
        list[str] | None, typer.Option("--only", help="Rows whose name holds this; may be given again. Default: all.")
    ] = None,
    wire: Annotated[
        bool, typer.Option("--wire/--no-wire", help="Rows that need real frames and processes (rights, real time).")
    ] = True,
    tries: Annotated[
        int | None,
        typer.Option("--tries", min=1, help="Tries of every row, all to be right. Default: 1, on real frames 3."),
    ] = None,
    table: Annotated[Path | None, typer.Option("--table", help="Write the table as a page of Markdown.")] = None,
    store: Annotated[
        Path | None,
        typer.Option("--store", help="Keep outcomes in this file; the page then shows rows of earlier runs as well."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what became of every row as JSON.")] = False,
) -> None:
    """Inject every fault into the emulated bench and check what follows; exit code 6 if a row is not right.

    For each: cause found, time to rest, state of the drives, true shafts within their envelope, what the operator
    reads, no torque by itself afterwards, everything recorded before reads back.
    """
    from bench.configuration import load_bench
    from bench.matrix import ROWS, WIRE
    from bench.matrix.outcome import Envelope
    from bench.matrix.run import run_rows_often
    from bench.matrix.store import load, newest_outcomes, save
    from bench.matrix.summary import summary
    from bench.matrix.table import page
    from bench.proof.results import commit

    file = load_bench("rh380n")
    rows = [row for row in ROWS if not only or any(word in row.fault for word in only)]
    rows = [row for row in rows if wire or row.kind != WIRE]
    earlier = [] if store is None else load(store)
    outcomes, made_by, day = [], commit(), datetime.now(UTC).date().isoformat()
    for outcome in run_rows_often(rows, file, tries):
        outcome.commit, outcome.day = made_by, day
        outcomes.append(outcome)
        if not as_json:
            seen = "not seen at rest" if outcome.cause or not outcome.reaction else outcome.reaction
            stopped = seen if outcome.stopped_s is None else f"at rest after {outcome.stopped_s:.2f} s"
            verdict = "right" if outcome.passed else "NOT RIGHT: " + "; ".join(outcome.problems)
            rate = f"{outcome.right} of {outcome.tries} tries "
            say(f"{outcome.name:32} {outcome.cause.lower() or '-':24} {stopped:22} {rate}{verdict}")
        if store is not None:
            save(store, newest_outcomes(earlier, outcomes, ROWS))
    shown = newest_outcomes(earlier, outcomes, ROWS)
    if table is not None:
        envelope = Envelope.of(file.configuration)
        text = (
            f"motor {envelope.motor_speed:.0f} rad/s, load {envelope.load_speed:.0f} rad/s, {envelope.torque:.0f} N·m"
        )
        table.write_text(page(shown, text), "utf-8")
    if not as_json:
        say(summary(shown))
    if as_json:
        say(json.dumps([outcome.as_dict() for outcome in outcomes], ensure_ascii=False))
    if not all(outcome.passed for outcome in outcomes):
        raise typer.Exit(ExitCode.NOT_VALID)
