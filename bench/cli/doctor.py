"""``bench doctor``: what this machine offers for a bench in real time, and what to change."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import PlainConsole, say
from bench.cli.exit_codes import ExitCode

_STYLES = {"good": "green", "advice": "yellow", "bad": "bold red"}


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="doctor")(doctor)


def doctor(
    bench: Annotated[str, typer.Option("--bench", help="Name of a shipped bench, or path of a file.")] = "rh380n",
    bus: Annotated[
        str | None, typer.Option("--bus", help="Network interface; default: that of the bench file.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder recordings will go to.")] = Path("recordings"),
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
) -> None:
    """Check interface, rights, scheduling, processors, clock, disk and packages, and say what to change.

    Nothing is changed; it measures half a second of wake-ups and writes 32 MB to the disk. Exit code 6 if a bench on
    hardware would not run, or not punctually; advice alone does not count.
    """
    from rich.table import Table
    from rich.text import Text

    from bench.configuration import load_bench
    from bench.cycle.doctor.examine import examine

    findings = examine(load_bench(bench).configuration, bus, out)
    is_bad = any(finding.state == "bad" for finding in findings)
    if as_json:
        listed = [finding.as_dict() for finding in findings]
        say(json.dumps({"fit": not is_bad, "findings": listed}, ensure_ascii=False))
    else:
        table = Table(box=None, pad_edge=False)
        for name in ("", "check", "found", "to change"):
            table.add_column(name, overflow="fold")
        for finding in findings:
            mark = Text(finding.state.value, style=_STYLES[finding.state.value])
            table.add_row(mark, finding.check, finding.found, finding.change)
        PlainConsole(highlight=False).print(table)
    raise typer.Exit(ExitCode.NOT_VALID if is_bad else ExitCode.OK)
