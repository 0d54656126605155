"""``bench benchmark identify``: time and memory of identification, beside merely reading the files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say


def identify(
    folder: Annotated[Path, typer.Argument(help="Folder of recordings, such as the paper campaign's.")],
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Processes that read recordings.")] = 2,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Identify a folder and print time, memory, and the ratio to merely reading its files."""
    from bench.identification.benchmark import measure_identify

    figures = measure_identify(folder, jobs)
    if as_json:
        say(json.dumps(figures.as_dict()))
        return
    say(
        f"{figures.recordings} recordings, {figures.samples / 1e6:.1f} million samples a channel, {jobs} processes\n"
        f"identified in {figures.identify_s:.1f} s, peak memory {figures.peak_memory / 1e9:.2f} GB\n"
        f"reading every channel of the files takes {figures.read_s:.1f} s "
        f"(the channels used: {figures.read_used_s:.1f} s); ratio {figures.ratio:.2f}"
    )
