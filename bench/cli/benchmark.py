"""``bench benchmark``: figures of merit, measured by the program itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.cli._plain import say
from bench.cli.benchmarks.archive import archive
from bench.cli.benchmarks.coverage import coverage
from bench.cli.benchmarks.cycle import cycle
from bench.cli.benchmarks.faults import faults
from bench.cli.benchmarks.fuzz import fuzz
from bench.cli.benchmarks.identify import identify
from bench.cli.benchmarks.investigate import investigate
from bench.cli.benchmarks.mismatch import mismatch
from bench.cli.benchmarks.opening import opening
from bench.cli.benchmarks.page import page
from bench.cli.benchmarks.stop import stop
from bench.cli.benchmarks.twin import twin
from bench.cli.benchmarks.wire import wire
from bench.cli.exit_codes import ExitCode

if TYPE_CHECKING:
    from bench.campaigns.benchmark import CampaignFigures, SurvivalFigures


def register(app: typer.Typer) -> None:
    """Add the group of commands."""
    group = typer.Typer(help="Measure what the program achieves on this machine.", no_args_is_help=True)
    group.command(name="campaign")(campaign)
    group.command(name="survival")(survival)
    group.command(name="identify")(identify)
    group.command(name="coverage")(coverage)
    group.command(name="twin")(twin)
    group.command(name="investigate")(investigate)
    group.command(name="mismatch")(mismatch)
    group.command(name="wire")(wire)
    group.command(name="faults")(faults)
    group.command(name="fuzz")(fuzz)
    group.command(name="stop")(stop)
    group.command(name="cycle")(cycle)
    group.command(name="archive")(archive)
    group.command(name="page")(page)
    group.command(name="opening")(opening)
    app.add_typer(group, name="benchmark")


_Campaign = Annotated[str, typer.Argument(help="Name or path of a campaign.")]
_Bench = Annotated[str, typer.Option("--bench", help="Name or path of an emulated bench.")]
_Out = Annotated[
    Path | None, typer.Option("--out", help="Keep the recordings in this new folder; default: measure and remove them.")
]
_Json = Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")]


def campaign(name: _Campaign = "paper", bench: _Bench = "rh380n", out: _Out = None, as_json: _Json = False) -> None:
    """Run a whole campaign in fast time and print times real time, memory, disk, and how many files are valid.

    The paper's campaign is some eight hours of bench time at 2 kHz; it takes minutes.
    """
    from bench.campaigns.benchmark import measure_campaign

    figures = measure_campaign(name, bench, out)
    if as_json:
        say(json.dumps(figures.as_dict()))
    else:
        _print_campaign(figures)
    if figures.valid < figures.recordings or figures.failed:
        raise typer.Exit(ExitCode.NOT_VALID)


def survival(
    name: _Campaign = "paper",
    bench: _Bench = "rh380n",
    kills: Annotated[int, typer.Option(min=1, help="How often the running campaign is killed.")] = 50,
    life: Annotated[float, typer.Option(min=0.1, help="Mean time in s a run records before it is killed.")] = 4.0,
    seed: Annotated[int, typer.Option(help="Seed of the moments.")] = 0,
    out: _Out = None,
    as_json: _Json = False,
) -> None:
    """Kill a campaign (SIGKILL) at random moments and run it again each time.

    Prints whether it ended with the set of points of an undisturbed run, every file valid; exit code 6 if not.
    """
    from bench.campaigns.benchmark import measure_survival

    figures = measure_survival(name, bench, kills, life, seed, out)
    if as_json:
        say(json.dumps(figures.as_dict()))
    else:
        _print_survival(figures)
    if not figures.survived:
        raise typer.Exit(ExitCode.NOT_VALID)


def _print_campaign(figures: CampaignFigures) -> None:
    from bench.cli._text import duration_text

    say(
        f"{figures.campaign}: {figures.recordings} recordings, {figures.valid} valid, {figures.failed} failed points\n"
        f"{figures.cycles:,} cycles, {duration_text(figures.bench_time_s)} of bench time in {figures.wall_s:.1f} s:"
        f" {figures.times_real_time:.0f} times real time ({figures.cpu_s:.0f} s of CPU)\n"
        f"peak memory {figures.peak_memory_bytes / 1e6:.0f} MB, disk {figures.disk_bytes / 1e6:.0f} MB"
    )


def _print_survival(figures: SurvivalFigures) -> None:
    verdict = "the same set of points as an undisturbed run" if figures.survived else "NOT the same set of points"
    say(
        f"{figures.campaign}: killed {figures.kills} times; {figures.points_done} of {figures.points} points done,"
        f" {figures.cut_short} recordings cut short and kept, {figures.valid} of {figures.recordings} files valid:"
        f" {verdict} ({figures.wall_s:.0f} s)"
    )
