"""``bench import``: other laboratories' measurements become recordings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from bench.cli.exit_codes import ExitCode


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="import")(import_)


def import_(
    mapping: Annotated[Path, typer.Argument(help="TOML file: which variable is which channel, in which unit.")],
    out: Annotated[Path, typer.Option("--out", help="Folder the recordings go to.")],
    data: Annotated[
        Path | None, typer.Option("--data", help="Folder of the files to import; default: that of the mapping.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Import MAT (5 and 7.3), CSV, HDF5 or TDMS files through a mapping file, and write campaign.json.

    docs/examples/emps.toml is a mapping to start from. What a missing channel rules out is said in one sentence.
    Exit code 6 when a file could not be imported; the others are.
    """
    from bench.recording import Rejected
    from bench.recording.importing import import_recordings
    from bench.recording.manifest import rebuild, write_manifest

    rows: list[dict[str, Any]] = []
    for done in import_recordings(mapping, out, data):
        if isinstance(done, Rejected):
            rows.append({"source": str(done.file), "error": done.why})
            if not as_json:
                typer.echo(done.why)
            continue
        recording = done.recording
        rows.append(
            {
                "source": str(done.source),
                "recording": str(recording.path),
                "rows": recording.size,
                "sample_rate": recording.sample_rate,
                "channels": recording.channels,
                "consequences": done.consequences,
            }
        )
        if not as_json:
            seconds = recording.size / recording.sample_rate
            typer.echo(f"{recording.path}: {recording.size} rows ({seconds:.1f} s) of {', '.join(recording.channels)}")
            for sentence in done.consequences:
                typer.echo(f"  {sentence}")
    if any("recording" in row for row in rows):
        write_manifest(out, rebuild(out))
    if as_json:
        typer.echo(json.dumps(rows, ensure_ascii=False))
    if any("error" in row for row in rows):
        raise typer.Exit(ExitCode.NOT_VALID)
