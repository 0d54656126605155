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
    """Stop everything that runs on this computer.

    STOP is sent directly to the run, not through the service. A run that does not answer within a second gets a
    signal; if it hangs, its bus process stops the drives. The command prints whether both shafts were observed at
    rest. It is not an emergency stop.
    """
    import getpass
    from threading import Thread

    from bench.stop_button import find, press

    found = find.runs()
    if not found:
        typer.echo(json.dumps([]) if as_json else "Nothing runs on this computer.")
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
    if as_json:
        said = [{"pid": pid, "at_rest": seen.at_rest, "text": seen.text} for pid, seen in outcomes.items()]
        typer.echo(json.dumps(said, ensure_ascii=False))
    else:
        for seen in outcomes.values():
            typer.echo(seen.text)
    if not all(seen.at_rest for seen in outcomes.values()):
        raise typer.Exit(ExitCode.DEVICE)
