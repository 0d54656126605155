"""``bench benchmark mismatch``: time and memory of the mismatch analysis, by phase."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say
from bench.cli.mismatch import one_thread


def mismatch(
    folder: Annotated[Path, typer.Argument(help="Folder of recordings.")],
    simulation: Annotated[Path | None, typer.Option("--simulation", help="Simulation file to compare with.")] = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Processes that read.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Compare a folder with the simulation; print time by phase, memory, and ratios to reading and to identification.

    One thread of linear algebra (OPENBLAS_NUM_THREADS says otherwise), as `bench mismatch` runs. Memory is that of the
    process that compares and, where others read for it, of the largest of them for each.
    """
    one_thread()
    from bench.mismatch.benchmark import measure_mismatch

    figures = measure_mismatch(folder, simulation, jobs)
    if as_json:
        say(json.dumps(figures.as_dict()))
        return
    result = figures.as_dict()
    say(
        f"{figures.recordings} recordings, {figures.samples / 1e6:.2f} million samples a channel: {figures.verdict}\n"
        f"{figures.total_s:.1f} s ({figures.cpu_s:.1f} s of CPU): reading {figures.reading_s:.1f} s,"
        f" searching {figures.searching_s:.1f} s, scoring and report {figures.scoring_s:.1f} s;"
        f" peak memory {figures.peak_memory / 1e9:.2f} GB\n"
        f"merely reading the files takes {figures.read_s:.1f} s: ratio {result['ratio_to_reading']:.1f}"
    )
    if figures.identify_s is not None:
        say(f"identifying them takes {figures.identify_s:.1f} s: ratio {result['ratio_to_identify']:.1f}")
