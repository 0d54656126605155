"""``bench benchmark identify``: time and memory of identification, beside merely reading the files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.cli._plain import say

if TYPE_CHECKING:
    from bench.identification.benchmark import Cost


def identify(
    folder: Annotated[Path, typer.Argument(help="Folder of recordings, such as the paper campaign's.")],
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Processes that read recordings.")] = 2,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Identify a folder and print time, memory, the ratio to only reading its files, and what compression costs."""
    from bench.identification.benchmark import measure_identify

    figures = measure_identify(folder, jobs)
    if as_json:
        say(json.dumps(figures.as_dict()))
        return
    packed = figures.compression
    say(
        f"{figures.recordings} recordings, {figures.samples / 1e6:.1f} million samples a channel, {jobs} processes\n"
        f"identified in {_time(figures.identify)}, peak memory {figures.peak_memory / 1e9:.2f} GB\n"
        f"reading every channel of the files takes {_time(figures.read)} "
        f"(the channels used: {_time(figures.read_used)})\n"
        f"ratio {figures.ratio:.2f} by the clock, {figures.processor_ratio:.2f} of processor time\n"
        f"compression, {packed.recordings} recordings with {packed.rows / 1e6:.2f} million rows: "
        f"{packed.bytes / 1e6:.1f} MB and {packed.read_s:.3f} s of processor time to read every channel; without "
        f"{packed.plain_bytes / 1e6:.1f} MB and {packed.plain_read_s:.3f} s; ratio {packed.ratio:.1f}"
    )


def _time(cost: Cost) -> str:
    return f"{cost.wall_s:.1f} s ({cost.processor_s:.1f} s of processor time)"
