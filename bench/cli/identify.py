"""``bench identify``: from a folder of recordings to a validated model."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.cli._plain import PlainConsole, escaped, line, say
from bench.errors import BenchError, RecordingError
from bench.whole import write_whole

if TYPE_CHECKING:
    from rich.console import Console

    from bench.identification import Identification, Options

HIGHEST_ORDER = 1e5
"""More orders than any encoder of a gearbox has counts."""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="identify")(identify)


def identify(
    folder: Annotated[Path, typer.Argument(help="Folder of recordings.")],
    out: Annotated[Path, typer.Option("--out", help="Where the simulation file goes.")] = Path("model.json"),
    report: Annotated[
        Path | None, typer.Option("--report", help="Folder for report.html and summary.json; default: no report.")
    ] = None,
    figures: Annotated[
        str | None,
        typer.Option(
            "--figures", help="'paper': the paper's figures 4 to 7 as PNG, in the report's folder or figures."
        ),
    ] = None,
    method: Annotated[
        str, typer.Option("--method", help="Whose coefficients go into the simulation file: refined or paper.")
    ] = "refined",
    orders: Annotated[
        str,
        typer.Option(
            "--orders",
            help="'paper' (the paper's choice for the gearbox), 'proposed' (and those the spectra show), or 1,3,7.297.",
        ),
    ] = "paper",
    notch: Annotated[
        str,
        typer.Option(
            "--notch", help="Orders of the load motor's ripple: 'found' in the load torque, a list, or '' for none."
        ),
    ] = "found",
    pole_pairs: Annotated[
        int | None,
        typer.Option("--pole-pairs", min=1, help="The load motor's: its ripple is at 6 and 12 times as many orders."),
    ] = None,
    band_limit: Annotated[
        float | None,
        typer.Option("--band-limit", help="Hz, low-pass for imported recordings; default: a tenth of their rate."),
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Processes that read recordings.")] = 2,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON, nothing else.")] = False,
) -> None:
    """Identify transmission error, friction, heat balance and load side, by the paper's method and a refined one.

    Recordings of kind validation are scored and not used in any fit. Parameters that the recordings do not determine
    are listed without a value.
    """

    from bench.identification import Options, identify_folder, to_json, to_simulation, with_proposed_orders
    from bench.identification.summary import has_numbers

    if method not in ("refined", "paper"):
        raise BenchError(f"--method is '{method}', it should be refined or paper.")
    if figures not in (None, "paper"):
        raise BenchError(f"--figures is '{figures}', it should be paper.")
    console = PlainConsole(stderr=as_json, highlight=False)
    chosen = None if orders in ("paper", "proposed") else parse_ratios(orders, "--orders")
    options = Options(chosen, _notch(notch, pole_pairs), jobs, band_limit)
    found = _with_progress(folder, options, console)
    if orders == "proposed":
        found = identify_folder(folder, with_proposed_orders(found, options))
    simulation = to_simulation(found, method)
    if not has_numbers(simulation):
        _print_notes(console, found)
        raise RecordingError(
            f"{folder}: nothing is identified, so no simulation file was written; see the notes above."
        )
    out.parent.mkdir(parents=True, exist_ok=True)
    simulation.save(out)
    summary = to_json(found) | {"model": str(out), "method": method}
    if report is not None:
        from bench.identification.report import write_report

        summary["report"] = str(write_report(found, report))
        write_whole(report / "summary.json", json.dumps(summary, indent=1, ensure_ascii=False))
    if figures is not None:
        summary["figures"] = _figures(console, found, report or out.parent / "figures")
    if as_json:
        say(json.dumps(summary, ensure_ascii=False))
    else:
        _print(console, found, out, report)


def _figures(console: Console, found: Identification, folder: Path) -> list[str]:
    from bench.identification.report.paper_figures import write_paper_figures

    paths, missing = write_paper_figures(found, folder)
    for sentence in (*(f"Figure: {path}" for path in paths), *missing):
        console.print(line(sentence), markup=False)
    return [str(path) for path in paths]


def _notch(text: str, pole_pairs: int | None) -> tuple[int, ...] | None:
    """Orders to take off; None for those that are found."""
    from bench.identification.series.ripple import of_pole_pairs

    if pole_pairs is not None:
        if text != "found":
            raise BenchError("--notch and --pole-pairs both say where the ripple is; give one of them.")
        return of_pole_pairs(pole_pairs)
    if text == "found":
        return None
    return parse_orders(text, "--notch") if text else ()


def parse_orders(text: str, option: str) -> tuple[int, ...]:
    """Whole numbers of a list such as 1,3,46, ascending; BenchError naming ``option`` where it is none."""
    try:
        values = tuple(sorted({int(part) for part in text.split(",")}))
    except ValueError as error:
        raise BenchError(f"{option} is '{text}', it should be whole numbers such as 1,3,46.") from error
    if not values or values[0] < 1:
        raise BenchError(f"{option} is '{text}', harmonic orders should be whole numbers from 1.")
    return values


def parse_ratios(text: str, option: str) -> tuple[float, ...]:
    """Numbers from 1 of a list such as 1,3,7.297, ascending; BenchError naming ``option`` where it is none."""
    try:
        values = tuple(sorted({float(part) for part in text.split(",")}))
    except ValueError as error:
        raise BenchError(f"{option} is '{text}', it should be numbers such as 1,3,7.297.") from error
    if not all(1.0 <= value < HIGHEST_ORDER for value in values):
        raise BenchError(f"{option} is '{text}', harmonic orders should be from 1 to {HIGHEST_ORDER:g}.")
    return tuple(int(value) if value == int(value) else value for value in values)


def _with_progress(folder: Path, options: Options, console: Console) -> Identification:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from bench.identification import identify_folder

    columns = (TextColumn("reading recordings"), BarColumn(30), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        row = bar.add_task("")
        return identify_folder(folder, options, lambda done, total: bar.update(row, completed=done, total=total))


def _print(console: Console, found: Identification, out: Path, report: Path | None) -> None:
    from bench.identification.summary import parameters, verdict
    from bench.identification.tables import error_table, parameter_table

    if found.scores:
        console.print(error_table(found))
    if parameters(found):
        console.print(parameter_table(found))
    new = [p for p in found.proposals if not p.used and p.order not in found.notch_orders]
    if new:
        listed = ", ".join(f"{p.order} ({p.part}, {1e6 * p.amplitude:.2f} µrad)" for p in new[:12])
        console.print(f"Orders that stand out and are not used ({len(new)}): {listed}", markup=False)
    _print_notes(console, found)
    if found.scores:
        console.print(verdict(found), markup=False)
    console.print(
        f"Simulation file: [bold]{escaped(out)}[/]"
        + (f", report: [bold]{escaped(report / 'report.html')}[/]" if report else "")
    )


def _print_notes(console: Console, found: Identification) -> None:
    """What was not identified or is doubtful, and which recordings were not used, a sentence each."""
    from bench.identification.summary import doubtful

    for sentence in (*doubtful(found).values(), *found.sentences):
        console.print(f"• {line(sentence)}", markup=False)
    for skipped in found.skipped[:20]:
        console.print(f"• {line(skipped.why)}", markup=False)
    if len(found.skipped) > 20:
        console.print(f"• … and {len(found.skipped) - 20} more in the summary (--json).")
