"""``bench stop``: bring the bench to rest from a shell, whatever has become of service and page."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from bench.cli.exit_codes import ExitCode

_PATIENCE_S = 20.0


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="stop")(stop)


def stop(
    by: Annotated[str | None, typer.Option("--by", help="Who stops the bench; by default your user's name.")] = None,
    patience: Annotated[float, typer.Option(help="How long to watch for rest, s.")] = _PATIENCE_S,
    as_json: Annotated[bool, typer.Option("--json", help="Print what was seen as JSON, nothing else.")] = False,
) -> None:
    """Stop every run on this computer; where BENCH_RUNTIME names a runtime folder, the runs of that folder.

    Runs that are seen but have another runtime folder are not stopped: they are named, with the command that stops
    them. If none but such runs are there, the exit code is 5.

    STOP is sent directly to the run, not through the service. A run that does not answer within a second gets a
    signal; if it hangs, its bus process stops the drives. The command prints whether both shafts were observed at
    rest. It is not an emergency stop.
    """
    import getpass
    from threading import Thread

    from bench.stop_button import find, press

    found, others = find.runs(), find.elsewhere()
    if not found and not others:
        typer.echo(json.dumps([]) if as_json else f"No run was seen; looked at: {find.looked_at()}.")
        return
    name = by or getpass.getuser()
    outcomes: dict[int, press.Outcome] = {}

    def say(text: str) -> None:
        if not as_json:
            typer.echo(text)

    def one(run: find.Found) -> None:
        outcomes[run.pid] = press.stop(run, name, patience, say)

    threads = [Thread(target=one, args=(run,), daemon=True) for run in found]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    texts = {run.pid: f"not stopped: {find.how_to_stop(run)}" for run in others}
    if as_json:
        said = [{"pid": pid, "at_rest": seen.at_rest, "text": seen.text} for pid, seen in outcomes.items()]
        not_stopped = [{"pid": pid, "at_rest": None, "text": text} for pid, text in texts.items()]
        typer.echo(json.dumps([*said, *not_stopped], ensure_ascii=False))
    else:
        if not found:
            typer.echo(f"No run was seen in {find.looked_at()}.")
        for text in (*(seen.text for seen in outcomes.values()), *texts.values()):
            typer.echo(text)
    if not found or not all(seen.at_rest for seen in outcomes.values()):
        raise typer.Exit(ExitCode.DEVICE)
