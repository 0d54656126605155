"""``bench investigate``: experiments that separate what recordings leave open, designed, run and looked at."""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.cli._plain import PlainConsole, escaped, say
from bench.cli.exit_codes import exit_code_help

if TYPE_CHECKING:
    from rich.console import Console

    from bench.configuration import BenchConfiguration, BenchFile

_HELP = f"""Analyse recordings, run the experiment that best separates the remaining explanations, analyse again.

It continues until everything is named, nothing more can be gained, or the budget of bench time is used up.

Each experiment is the one with the largest expected information per hour of bench time, among all points the bench
can do within its limits: as found, after a warm-up, after a cooling. On hardware each waits for a confirmation at the
terminal (unless unattended.may of the bench file names experiment). The results are in investigation.json and
investigation.md. The same command continues where it was stopped.

Examples: [bold]bench investigate mine --out asked[/], [bold]bench investigate mine --out asked --plan-only[/]

{exit_code_help()}
"""
SECONDS_AN_HOUR = 3600.0


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="investigate", help=_HELP)(investigate)


def investigate(
    folder: Annotated[Path, typer.Argument(help="Folder of recordings.")],
    out: Annotated[Path, typer.Option("--out", help="For the experiments, their recordings, the reports and the log.")],
    bench: Annotated[str, typer.Option("--bench", help="Bench they are of: shipped name, or file.")] = "rh380n",
    hours: Annotated[float, typer.Option("--hours", min=0.0, help="Budget of bench time.")] = 8.0,
    experiments: Annotated[int, typer.Option("--experiments", min=0, help="At most so many.")] = 5,
    confidence: Annotated[
        float, typer.Option("--confidence", min=0.0, max=0.9, help="Confidence that each finding needs.")
    ] = 0.7,
    plan_only: Annotated[
        bool,
        typer.Option("--plan-only", help="Design the next experiment and print what it should decide; run nothing."),
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the emulated plant's noise.")] = 0,
    conceal: Annotated[
        int | None, typer.Option(min=0, help="Seed of the plant, as bench run had it for the folder.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print investigation.json.")] = False,
) -> None:
    """Investigate a folder (the help text stands in _HELP)."""
    from bench.cli.mismatch import one_thread

    one_thread()
    from bench.configuration import concealing, load_bench
    from bench.investigate.log import text
    from bench.investigate.loop import Goal
    from bench.investigate.loop import investigate as go
    from bench.proof.seal import opened, require_same_seal

    file = load_bench(bench)
    digest = None if conceal is None else opened(file, conceal)[1]
    require_same_seal(folder, digest)
    if conceal is not None:
        file = concealing(file, conceal)
    console = PlainConsole(stderr=True, highlight=False)
    lab = _Bench(file, seed, console, digest)

    def report_progress(what: str) -> None:
        if not as_json:
            console.print(escaped(what), soft_wrap=True)

    log = go(
        folder, out, lab, Goal(confidence, hours, experiments), report_progress=report_progress, plan_only=plan_only
    )
    content = log.to_json()
    say(json.dumps(content, ensure_ascii=False) if as_json else text(content))


class _Bench:
    """The bench of a file: experiments are run as ``bench run`` runs a campaign.

    ``sealed`` is the hash of what its plant conceals; it stands beside the recordings of each experiment.
    """

    def __init__(self, file: BenchFile, seed: int, console: Console, sealed: str | None) -> None:
        self._file, self._seed, self._console, self._sealed = file, seed, console, sealed

    @property
    def bench(self) -> BenchConfiguration:
        """Its configuration."""
        return self._file.configuration

    def celsius(self, last: float) -> float:
        """As the last recording ended; an emulated bench is a new one each time, as cold as its surroundings."""
        return self.bench.nominal.ambient_temperature if self.bench.bus.in_process else last

    def run(self, campaign: Path, folder: Path, after: datetime) -> float:
        """Run a campaign; hours of bench time. A stop of it, by whomever, is an error: nothing goes on by itself."""
        from bench.campaigns import load_campaign
        from bench.campaigns.execution.session import run_campaign
        from bench.cli._operator import somebody
        from bench.cli._progress import ProgressListener
        from bench.errors import ConfigurationError, LimitError
        from bench.locks import bus_in_use, service_for
        from bench.proof.seal import seal

        if not self.bench.bus.in_process:
            somebody(self.bench, "experiment", f"Run {campaign} now?")
        if service_for(self._file) is not None:
            raise ConfigurationError(
                f"a service has this bench: run {campaign} on its page, put the recordings into {folder}, "
                "and give the same command again"
            )
        loaded = load_campaign(campaign)
        seal(folder, self._sealed)
        with bus_in_use(self._file), ProgressListener(0.0, self._console, quiet=True) as listener:
            # recordings are the same data set only if they stand behind those before
            summary = run_campaign(self._file, loaded, folder, listener, seed=self._seed_of(folder), not_before=after)
        if summary.end.kind.name != "FINISHED":
            raise LimitError(f"the experiment in {folder} ended early: {summary.end.text}; the same command goes on")
        return summary.bench_time_s / SECONDS_AN_HOUR

    def _seed_of(self, folder: Path) -> int:
        """Another noise in each experiment."""
        return self._seed + 1 + int(folder.name.rsplit("-", 1)[-1])
