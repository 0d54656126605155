"""``bench trend``: one gearbox over months, from the campaigns an archive has of it."""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.cli._plain import PlainConsole, line, say
from bench.errors import BenchError

if TYPE_CHECKING:
    from rich.console import Console

    from bench.archive import Index
    from bench.trend import Series, Trend


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="trend")(trend)


def trend(
    root: Annotated[Path, typer.Argument(help="Folder of campaign folders.", exists=True, file_okay=False)],
    gearbox: Annotated[
        str | None, typer.Option("--gearbox", help="Serial number; default: the only one that is there.")
    ] = None,
    since: Annotated[
        str | None, typer.Option("--since", help="Leave out what was before this date, as after a repair: 2026-05-01.")
    ] = None,
    identify: Annotated[
        bool,
        typer.Option(
            "--identify/--no-identify", help="Identify campaigns that are not identified yet, which takes some time."
        ),
    ] = True,
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Processes that read recordings.")] = 2,
    as_json: Annotated[bool, typer.Option("--json", help="Print everything as JSON.")] = False,
) -> None:
    """Report what changed since a gearbox's last campaign, and its trend over all campaigns, with control limits.

    Orders, hysteresis, stiffness, friction, heat resistance and noise are those of each campaign's identification,
    which is kept beside the folders. Limits take its uncertainty into account and rest on three earlier campaigns at
    least.
    """
    from bench.trend import gearboxes, identify_missing, trend_of
    from bench.trend.book import index_of

    console = PlainConsole(stderr=as_json, highlight=False, width=120)
    since_s = _timestamp(since)
    index = index_of(root)
    serial = _only_gearbox(gearboxes(index), root) if gearbox is None else gearbox
    if identify:
        _identify(console, root, serial, index, since_s, jobs, identify_missing)
    found = trend_of(root, serial, index, since_s)
    if as_json:
        say(json.dumps(found.as_dict(), ensure_ascii=False))
    else:
        _print(console, found)


def _timestamp(text: str | None) -> float | None:
    if text is None:
        return None
    try:
        return datetime.fromisoformat(text).astimezone().timestamp()
    except ValueError as error:
        raise BenchError(f"--since is '{text}', it should be a date such as 2026-05-01.") from error


def _only_gearbox(known: dict[str, int], root: Path) -> str:
    named = {serial: count for serial, count in known.items() if serial}
    if len(named) == 1:
        return next(iter(named))
    if not named:
        raise BenchError(f"{root}: no recording names its gearbox; give the bench file gearbox.serial.")
    listed = ", ".join(f"{serial} ({count} campaigns)" for serial, count in named.items())
    raise BenchError(f"{root}: there are several gearboxes: {listed}; choose one with --gearbox.")


def _identify(
    console: Console, root: Path, serial: str, index: Index, since_s: float | None, jobs: int, work: Any
) -> None:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    columns = (TextColumn("identifying {task.description}"), BarColumn(30), MofNCompleteColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        row = bar.add_task("")
        work(
            root,
            serial,
            index,
            since_s,
            jobs,
            lambda folder, done, total: bar.update(row, description=line(folder), completed=done, total=total),
        )


def _print(console: Console, found: Trend) -> None:
    from rich.table import Table

    for sentence in found.lines:
        console.print(line(sentence), markup=False)
    at = found.reference
    where = "" if at is None else f", without load at {at.speed_deg_s:g} °/s and {at.temperature_degc:g} °C"
    table = Table(title=f"{line(found.gearbox)}: last campaign of each quantity{where}", box=None, pad_edge=False)
    for heading in ("quantity", "last", "±", "before", "limits", "unit", "campaigns", ""):
        table.add_column(heading, justify="left" if heading in ("quantity", "unit") else "right")
    for one in found.series:
        table.add_row(*_row(one))
    if found.series:
        console.print(table)
    for campaign in found.campaigns:
        if campaign.state != "identified":
            console.print(f"• {line(campaign.folder)}: {campaign.state} {line(campaign.why)}", markup=False)


def _row(one: Series) -> tuple[str, ...]:
    scale, last = one.quantity.scale, one.points[-1]
    before = f"{one.points[-2].value.value * scale:.4g}" if len(one.points) > 1 else ""
    limits = last.limits
    sides = "" if limits is None else f"{limits.lower * scale:.4g} … {limits.upper * scale:.4g}"
    value, std = last.value.value * scale, last.value.std * scale
    verdict = "OUTSIDE" if last.outside else ""
    return (
        one.quantity.name,
        f"{value:.4g}",
        f"{std:.2g}",
        before,
        sides,
        one.quantity.unit,
        str(len(one.points)),
        verdict,
    )
