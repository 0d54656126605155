"""``bench repair``: what a kill or a power cut left becomes a valid recording."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from bench.cli._plain import line, say
from bench.cli.exit_codes import ExitCode


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="repair")(repair)


def repair(
    given: Annotated[
        list[Path], typer.Argument(help="Unfinished recordings (.part), or campaign folders.", metavar="FILE...")
    ],
    out: Annotated[Path | None, typer.Option("--out", help="Where a single file's repaired recording goes.")] = None,
    keep: Annotated[bool, typer.Option("--keep", help="Leave the unfinished file its name.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Make valid recordings, marked as cut short, of unfinished files; in a folder, rebuild campaign.json as well.

    No unfinished file is deleted: it is called NAME.part.repaired afterwards, or keeps its name where the result is
    not valid.

    The plan and the points still to do are kept if the old campaign.json can be read; recordings do not contain them.
    Exit code 6 when a file is beyond repair or the recording made of it is not valid.
    """
    from bench.errors import RecordingError
    from bench.recording.manifest import rebuild, write_manifest
    from bench.recording.repairing import repair as restore

    if out is not None and (len(given) != 1 or given[0].is_dir()):
        raise typer.BadParameter("--out goes with a single file", param_hint="--out")
    rows: list[dict[str, Any]] = []
    for path in given:
        if not path.exists():
            rows.append({"file": str(path), "error": f"{path}: there is no such file or folder."})
            continue
        for source in sorted(path.glob("*.part")) if path.is_dir() else [path]:
            try:
                done = restore(source, out, keep=keep)
            except RecordingError as error:
                rows.append({"file": str(source), "error": str(error)})
                continue
            rows.append(
                {
                    "file": str(source),
                    "recording": str(done.path),
                    "rows": done.rows,
                    "rows_lost": done.rows_lost,
                    "complete": done.complete,
                    "valid": done.valid,
                    "violations": done.violations,
                    "source": str(done.source),
                }
            )
        if path.is_dir():
            write_manifest(path, rebuild(path))
    if as_json:
        say(json.dumps(rows, ensure_ascii=False))
    else:
        for row in rows:
            say(line(row.get("error") or _sentence(row)))
        if not rows:
            say("nothing to repair; campaign.json was rebuilt")
    if any("error" in row or not row["valid"] for row in rows):
        raise typer.Exit(ExitCode.NOT_VALID)


def _sentence(row: dict[str, Any]) -> str:
    how = "complete" if row["complete"] else "cut short"
    lost = f", {row['rows_lost']} rows beyond repair" if row["rows_lost"] else ""
    wrong = "" if row["valid"] else f"; NOT valid: {row['violations'][0]}"
    return f"{row['recording']}: {row['rows']} rows, {how}{lost}{wrong} ({row['source']} is kept)"
