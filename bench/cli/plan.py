"""``bench plan``: what a campaign will do, before anything moves."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Annotated

import typer

from bench.cli._plain import PlainConsole, escaped, say

if TYPE_CHECKING:
    from bench.campaigns import Plan


_HEADINGS = ("no.", "what", "load\nN·m", "speed\n°/s", "for\n°C", "starts", "takes", "expected\n°C", "energy")


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="plan")(plan)


def plan(
    campaign: Annotated[str, typer.Argument(help="Name of a shipped campaign, or path of a TOML or Python file.")],
    bench: Annotated[str, typer.Option("--bench", help="Name of a shipped bench, or path of a file.")] = "rh380n",
    start_temperature: Annotated[
        float | None, typer.Option(help="Lubricant temperature in °C at the start; default: the surroundings.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the plan as JSON.")] = False,
) -> None:
    """Print every point with its time, expected temperature and energy; refuse a campaign that would break a limit.

    Shipped campaigns: quick, short, paper, distinguish. Times of heating come from the thermal model of the bench file.
    """

    from bench.campaigns import load_campaign, make_plan
    from bench.configuration import load_bench

    made = make_plan(load_campaign(campaign), load_bench(bench).configuration, start_temperature)
    if as_json:
        say(json.dumps(made.as_dict(), ensure_ascii=False))
        return
    print_plan(made, PlainConsole())


def print_plan(made: Plan, console: object, rows: bool = True) -> None:
    """Print the points (if ``rows``) and the sums of a plan."""
    from rich.console import Console
    from rich.table import Table

    from bench.cli._text import clock_text, duration_text, energy_text

    assert isinstance(console, Console)
    if rows:
        table = Table(box=None, header_style="bold", pad_edge=False)
        for heading in _HEADINGS:
            table.add_column(heading, no_wrap=True, justify="left" if heading == "what" else "right")
        for task in made.tasks:
            point = task.point
            table.add_row(
                str(task.number or ""),
                escaped(point.sequence) + (f" #{point.repeat}" if point.repeat > 1 else ""),
                f"{point.load_torque:.4g}",
                f"{math.degrees(point.velocity):.3g}",
                "found" if point.temperature is None else f"{point.temperature:.1f}",
                clock_text(task.start_s),
                clock_text(task.duration_s),
                f"{task.start_temperature:.1f}→{task.end_temperature:.1f}",
                energy_text(task.energy_j),
                style="dim" if task.is_preparation else None,
            )
        console.print(table)
    console.print(
        f"[bold]{escaped(made.campaign)}[/] on [bold]{escaped(made.bench)}[/]:"
        f" {made.points} points, {made.heatings} heatings"
        f" ({duration_text(made.heating_s)}), {duration_text(made.duration_s)} of bench time,"
        f" {energy_text(made.energy_j)}, from {made.start_temperature:.1f} °C; no limit is broken."
    )
