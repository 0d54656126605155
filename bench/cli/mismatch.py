"""``bench mismatch``: where simulation and recordings differ, what physics was left out, and how much better it
fits.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="mismatch")(mismatch)


def mismatch(
    recordings: Annotated[Path, typer.Argument(help="Folder of recordings.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for report.json, report.html and model.json.")],
    simulation: Annotated[
        Path | None,
        typer.Option(
            "--simulation", help="Simulation file to compare with; default: the nominal simulation, calibrated."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print report.json, nothing else.")] = False,
) -> None:
    """Compare the simulation with recordings: locate the mismatch, name the physics left out, model it, score it.

    The simulation is calibrated on a part of the recordings; whole operating points, the validation points always among
    them, are held out and only scored. What the recordings cannot tell apart is called ambiguous, what no term explains
    unknown.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    from bench.mismatch import run
    from bench.mismatch.page import sentence

    console = Console(stderr=True, highlight=False)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=as_json) as bar:
        task = bar.add_task("reading", total=1.0)
        report = run(
            recordings,
            out,
            simulation,
            lambda what, share: bar.update(task, description=what, completed=share),
        )
    if as_json:
        typer.echo(json.dumps(report.to_json(), allow_nan=False))
        return
    typer.echo(sentence(report))
    for channel, score in report.scores.items():
        typer.echo(
            f"  {channel:20s} floor {score.floor:.3g}, before {score.before:.3g}, after {score.after:.3g} "
            f"(after/floor {score.after / score.floor:.3f})"
        )
    typer.echo(f"report: {out / 'report.html'}")
