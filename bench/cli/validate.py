"""``bench validate``: do files meet the recording format."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import line, say
from bench.cli.exit_codes import ExitCode


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="validate")(validate)


def validate(
    files: Annotated[list[Path], typer.Argument(help="Recordings, or folders of recordings.", metavar="FILE...")],
    notes: Annotated[bool, typer.Option("--notes", help="Print what is allowed but worth knowing, too.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Check every rule of the recording format; one sentence for each violation (file, dataset, index, reason).

    Exit code 6 when a file is not valid.
    """
    from bench.recording.folder import recording_files
    from bench.recording.validation import validate as check

    paths = [path for given in files for path in recording_files(given)]
    results = [check(path) for path in paths]
    if as_json:
        rows = [{"file": str(r.path), "valid": r.valid, "violations": r.violations, "notes": r.notes} for r in results]
        say(json.dumps(rows, ensure_ascii=False))
    else:
        for result in results:
            for sentence in (*result.violations, *(result.notes if notes else ())):
                say(line(sentence))
        invalid = sum(not result.valid for result in results)
        say(f"{len(results)} files checked, {len(results) - invalid} valid, {invalid} not valid")
    if not all(result.valid for result in results):
        raise typer.Exit(ExitCode.NOT_VALID)
