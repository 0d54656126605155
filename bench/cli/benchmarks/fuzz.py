"""``bench benchmark fuzz``: spoiled files, and what becomes of them."""

from __future__ import annotations

import json
import math
import subprocess
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say
from bench.cli.exit_codes import ExitCode


def fuzz(
    only: Annotated[
        list[str] | None,
        typer.Option("--only", help="h5, part, model, bench, campaign, mapping or journal; may be given again."),
    ] = None,
    count: Annotated[int, typer.Option("--count", min=1, help="Files of each kind.")] = 2000,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the damage.")] = 0,
    first: Annotated[int, typer.Option("--first", min=0, help="Number of the first file: repeats a single case.")] = 0,
    minutes: Annotated[
        float | None,
        typer.Option("--minutes", help="Begin no file after this time; the table says how many were."),
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Kinds that are tried at once.")] = 2,
    table: Annotated[Path | None, typer.Option("--table", help="Write the table as a page of Markdown.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what became of every kind as JSON.")] = False,
) -> None:
    """Damage valid files at random and read them: recordings, unfinished ones, models, TOML files, journals.

    Counts refusals, crashes, hangs, tracebacks, wrong samples without a message, and files that are lost; exit code 6
    if there is one of the latter five.
    """
    from bench.fuzzing import KINDS
    from bench.fuzzing import fuzz as run
    from bench.fuzzing.page import page

    unknown = set(only or ()) - set(KINDS)
    if unknown:
        raise typer.BadParameter(f"{', '.join(unknown)} should be of {', '.join(KINDS)}", param_hint="--only")

    def progress(kind: str, done: int, asked: int) -> None:
        if not as_json and (done == asked or done % 500 == 0):
            say(f"{kind}: {done} of {asked}", err=True)

    tallies = run(only or KINDS, count, seed, jobs, progress, first, math.inf if minutes is None else 60.0 * minutes)
    if table is not None:
        command = f"bench benchmark fuzz --count {count}" + ("" if minutes is None else f" --minutes {minutes:g}")
        table.write_text(page(tallies, command, seed, _revision()), "utf-8")
    if as_json:
        say(json.dumps([tally.as_dict() for tally in tallies]))
    else:
        for tally in tallies:
            counts = ", ".join(f"{number} {outcome}" for outcome, number in tally.outcomes.most_common())
            say(f"{tally.kind:9} {tally.done} of {tally.asked}: {counts}")
            for number, outcome, text in tally.wrong:
                say(f"    case {number}: {outcome} {text}")
    if not all(tally.passed for tally in tallies):
        raise typer.Exit(ExitCode.NOT_VALID)


def _revision() -> str:
    """Ask git, which knows of work trees, for the revision of the program."""
    from bench.version import PACKAGE

    command = ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""
