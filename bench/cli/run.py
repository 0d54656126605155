"""``bench run``: a whole campaign into recordings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.cli._plain import PlainConsole, escaped, say
from bench.cli.exit_codes import ExitCode, exit_code_help, exit_code_of_stop
from bench.errors import ConfigurationError

if TYPE_CHECKING:
    from rich.console import Console

    from bench.campaigns.taken import Summary

_HELP = f"""Run a campaign on a bench and write one HDF5 recording per point.

On an emulated bench time runs as fast as the machine allows (--real-time for the clock's pace). It first prints what
will be done and how long it takes. At the end it prints a summary and draws the transmission error with its spectrum
(picture.png beside the recordings). Ctrl-C brings the bench to rest and finishes the recording.

Examples: [bold]bench run quick[/], [bold]bench run paper --out mine[/], [bold]bench run mine.toml --bench rv80n[/]

{exit_code_help()}
"""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="run", help=_HELP)(run)


def run(
    campaign: Annotated[
        str, typer.Argument(help="quick, short, paper, distinguish, or the path of a TOML or Python file.")
    ],
    bench: Annotated[str, typer.Option("--bench", help="Name of a shipped bench, or path of a file.")] = "rh380n",
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder for the recordings; default: recordings/<campaign>-<time>.")
    ] = None,
    bus: Annotated[
        str | None,
        typer.Option("--bus", help="Network interface: run through SOEM on real frames (a bench, or bench emulate)."),
    ] = None,
    real_time: Annotated[bool, typer.Option("--real-time", help="Run an emulated bench at the clock's pace.")] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Give torque again after a stop that was acknowledged and reset.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the emulated plant's noise.")] = 0,
    conceal: Annotated[
        int | None,
        typer.Option(min=0, help="Seed of a plant with concealed physics; bench prove --open reveals it."),
    ] = None,
    twin: Annotated[
        Path | None, typer.Option("--twin", help="Model (model.json) that watches each finished recording.")
    ] = None,
    twin_pause: Annotated[
        bool,
        typer.Option(
            "--twin-pause", help="Bring the bench to rest when the model no longer holds; the same command continues."
        ),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON, nothing else.")] = False,
) -> None:
    """Run a campaign (the help text stands in _HELP)."""
    import time

    from bench.campaigns import load_campaign, make_plan
    from bench.campaigns.execution.session import run_campaign
    from bench.campaigns.operator.directions import Directions
    from bench.campaigns.records.journal import require_same
    from bench.cli._operator import somebody
    from bench.cli._progress import ProgressListener
    from bench.cli._twin import say_seen, watched_by
    from bench.cli.plan import print_plan
    from bench.configuration import concealing, load_bench, on_interface
    from bench.locks import bus_in_use, service_for
    from bench.proof.seal import opened, require_same_seal, seal
    from bench.service.client import Client

    console = PlainConsole(stderr=as_json)
    if twin_pause and twin is None:
        raise ConfigurationError("--twin-pause asks for a model that watches; give one with --twin model.json")
    file, loaded = load_bench(bench), load_campaign(campaign)
    if bus is not None:
        file = on_interface(file, bus)
    address = service_for(file)
    if address is not None:
        if conceal is not None:
            raise ConfigurationError("a service has this bench; give --conceal to bench serve, or --bench another one")
        from bench.cli._joined import run_joined

        raise typer.Exit(run_joined(Client.at(address), campaign, out, real_time, seed, as_json, twin, twin_pause))
    if twin is not None:
        from bench.twin.companion import require_model

        require_model(twin)
    folder = out or Path("recordings") / f"{loaded.name}-{time.strftime('%Y%m%d-%H%M%S')}"
    digest = None if conceal is None else opened(file, conceal)[1]
    require_same_seal(folder, digest)
    if conceal is not None:
        # a folder of another campaign is refused by the run as well, but only when it has its seal
        require_same(folder, loaded, file)
        file = concealing(file, conceal)
    plan = make_plan(loaded, file.configuration)
    if not as_json:
        print_plan(plan, console, rows=len(plan.tasks) <= 12)
        console.print(f"Recordings go to [bold]{escaped(folder)}[/]. Ctrl-C brings the bench to rest.", soft_wrap=True)
    by = somebody(file.configuration, "resume", "May the bench move again?") if resume else None
    seal(folder, digest)
    began = time.monotonic()
    directions, keeps_pace = Directions(), real_time or not file.configuration.bus.in_process
    with watched_by(twin, folder, directions if twin_pause else None, console, keeps_pace) as heard:
        with bus_in_use(file), ProgressListener(plan.duration_s, console, quiet=as_json) as listener:
            summary = run_campaign(
                file, loaded, folder, listener, seed=seed, real_time=real_time, resumed_by=by, directions=directions
            )
        wall = time.monotonic() - began
    picture = _picture(folder, loaded.title)
    if as_json:
        more = {} if heard is None else {"twin": heard.as_dict()}
        say(json.dumps(_as_dict(summary, folder, picture, wall) | more, ensure_ascii=False))
    else:
        say_seen(heard, console)
        _print(summary, folder, picture, wall, console)
    raise typer.Exit(_exit_code(summary))


def _exit_code(summary: Summary) -> ExitCode:
    from bench.cycle.end import EndKind

    if summary.end.kind is EndKind.INTERRUPTED:
        return ExitCode.INTERRUPTED
    if summary.end.kind is EndKind.TRIPPED:
        return exit_code_of_stop(summary.end.cause)
    return ExitCode.NOT_VALID if summary.failed else ExitCode.OK


def _picture(folder: Path, title: str) -> Path | None:
    from bench.campaigns.picture import draw
    from bench.recording import Recording

    path = folder / "campaign.json"
    if not path.exists():  # stopped before anything was asked of the bench
        return None
    manifest = json.loads(path.read_text("utf-8"))
    files = [
        folder / entry["file"]
        for entry in manifest["recordings"]
        if entry["status"] == "done" and entry["kind"] in ("constant_velocity", "validation")
    ]
    if not files:
        return None
    return draw([Recording.open(path) for path in files[:4]], folder / "picture.png", title)


def _as_dict(summary: Summary, folder: Path, picture: Path | None, wall: float) -> dict[str, Any]:
    return {
        "folder": str(folder),
        "picture": None if picture is None else str(picture),
        "end": summary.end.kind.name.lower(),
        "text": summary.end.text,
        "recordings": len(summary.taken),
        "done_earlier": summary.earlier,
        "failed": [taken.recording_id for taken in summary.failed],
        "bench_time_s": summary.bench_time_s,
        "cycles": summary.cycles,
        "wall_time_s": wall,
        "torque_drift_nm": summary.tare_drift if summary.tare_drift == summary.tare_drift else None,
    }


def _print(summary: Summary, folder: Path, picture: Path | None, wall: float, console: Console) -> None:
    from bench.cli._text import count_text, duration_text

    if summary.earlier:
        console.print(f"Done by an earlier run and not repeated: {count_text(summary.earlier, 'point')}.")
    if summary.taken:
        size = sum(path.stat().st_size for path in folder.glob("*.h5"))
        console.print(
            f"[bold]{count_text(len(summary.taken), 'recording')}[/], {count_text(summary.cycles, 'cycle')},"
            f" {duration_text(summary.bench_time_s)} of bench time in {duration_text(wall)}"
            f" ({summary.bench_time_s / wall:.0f} times real time), {size / 1e6:.1f} MB",
            soft_wrap=True,
        )
    for taken in summary.failed:
        if taken.note != summary.end.text:
            console.print(
                f"[yellow]not passed[/] {escaped(taken.recording_id)} ({escaped(taken.label)}): {escaped(taken.note)}",
                soft_wrap=True,
            )
    if summary.tare_drift == summary.tare_drift:
        # a zero without a sign
        console.print(f"The torque sensor's zero drifted by {round(summary.tare_drift, 2) + 0.0:.2f} N·m.")
    if picture is not None:
        console.print(f"Transmission error and spectrum: [bold]{escaped(picture)}[/]", soft_wrap=True)
    if summary.end.text:
        headline = summary.end.headline
        text = summary.end.text.removeprefix(f"{headline}: ")
        console.print(f"[bold yellow]{headline}[/]: {escaped(text)}", soft_wrap=True)
    _say_what_next(summary, folder, console)


def _say_what_next(summary: Summary, folder: Path, console: Console) -> None:
    match summary.end.kind.name:
        case "TRIPPED":
            console.print(
                f"There is no torque before these three steps: bench acknowledge {folder}, bench reset {folder},"
                f" bench run … --resume (with the same --bench and --bus).{_record_text(summary, folder)}",
                soft_wrap=True,
                markup=False,
            )
        case "INTERRUPTED":
            console.print(
                f"The same command with [bold]--out {escaped(folder)}[/] continues from here.", soft_wrap=True
            )
        case _:
            if summary.taken:
                recording = folder / summary.taken[0].file
                console.print(f"Inspect a recording: [bold]bench inspect {escaped(recording)}[/]", soft_wrap=True)
            console.print(
                f"Identify the gearbox: [bold]bench identify {escaped(folder)} --out model.json --report report[/]",
                soft_wrap=True,
            )


def _record_text(summary: Summary, folder: Path) -> str:
    """Name the record of the stop, if there is one: a full disk may have taken none."""
    return "" if summary.stop_record is None else f" The record of the stop: {folder / summary.stop_record}."
