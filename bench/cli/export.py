"""``bench export``: recordings as MAT or CSV."""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say


class Form(StrEnum):
    """Formats that can be written."""

    MAT = "mat"
    CSV = "csv"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="export")(export)


def export(
    files: Annotated[list[Path], typer.Argument(help="Recordings, or folders of recordings.", metavar="FILE...")],
    form: Annotated[Form, typer.Option("--to", help="Format to write.")] = Form.MAT,
    out: Annotated[Path, typer.Option("--out", help="Folder the files go to; it is made if need be.")] = Path("."),
    as_json: Annotated[bool, typer.Option("--json", help="Print the files written as JSON.")] = False,
) -> None:
    """Write recordings for other tools, every channel as double in SI units (temperatures in °C).

    MAT: one variable a channel, with units, segments, events and header as structures. CSV: commented header lines,
    names with units, one line a sample. Every other tool can open the recordings themselves: they are HDF5.
    """
    from bench.errors import RecordingError
    from bench.names import require_name
    from bench.recording import Recording
    from bench.recording.exporting import EXPORTERS
    from bench.recording.folder import recording_files

    out.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    for path in [path for given in files for path in recording_files(given)]:
        recording = Recording.open(path)
        name = require_name(recording.recording_id, f"{path}: the recording id", RecordingError)
        target = out / f"{name}.{form.value}"
        EXPORTERS[form.value](recording, target)
        written.append(target)
        if not as_json:
            say(f"{target}: {recording.size} rows of {len(recording.channels)} channels")
    if as_json:
        say(json.dumps([str(path) for path in written], ensure_ascii=False))
