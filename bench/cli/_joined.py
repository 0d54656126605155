"""``bench run`` where a service has the bus: join its queue, follow the run, stop it with Ctrl-C."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from bench.cli._plain import PlainConsole, escaped, say
from bench.cli._text import count_text, duration_text
from bench.cli.exit_codes import ExitCode, exit_code_of_stop
from bench.safety import Cause
from bench.service.client import Client

_CODES: dict[str, ExitCode] = {
    "finished": ExitCode.OK,
    "failed_points": ExitCode.NOT_VALID,
    "interrupted": ExitCode.INTERRUPTED,
    "withdrawn": ExitCode.INTERRUPTED,
    "refused": ExitCode.BAD_INPUT,
    "device": ExitCode.DEVICE,
    "died": ExitCode.DEVICE,
}


def run_joined(
    client: Client,
    campaign: str,
    out: Path | None,
    real_time: bool,
    seed: int,
    as_json: bool,
    twin: Path | None = None,
    twin_pause: bool = False,
) -> ExitCode:
    """Ask the service for the run and follow it to its end; ``twin``: the model that watches it."""
    console = PlainConsole(stderr=as_json, highlight=False)
    asked = client.ask(campaign, out, real_time, seed, twin, twin_pause)
    console.print(
        f"A service has this bench ([bold]{escaped(client.url)}[/]); the run joins its queue.", soft_wrap=True
    )
    console.print(
        f"Recordings go to [bold]{escaped(asked['folder'])}[/]. Ctrl-C brings the bench to rest.", soft_wrap=True
    )
    if asked["state"] == "proposed":
        console.print(
            "Somebody else holds the controls: the run begins when they say so on the page, under Campaign.",
            soft_wrap=True,
        )
    running = False
    # a stop is a stop, whoever asks for it: as Ctrl-C does
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with Progress(BarColumn(30), TextColumn("{task.description}"), console=console, transient=True) as bar:
            row = bar.add_task("queued", total=1.0)
            for message in client.events():
                if message["type"] == "runs":
                    ours = next((run for run in message["runs"] if run["id"] == asked["id"]), None)
                    running = ours is not None and ours["state"] == "running"
                    if ours is not None and ours["state"] == "ended":
                        return _report_end(ours, console, as_json)
                elif running:
                    _show(bar, row, message)
    except KeyboardInterrupt:
        _stop(client, asked["id"], console)
        return ExitCode.INTERRUPTED
    finally:
        signal.signal(signal.SIGTERM, before)
    console.print("The service ended; the run goes on without it. Start bench serve again to watch or stop it.")
    return ExitCode.DEVICE


def _stop(client: Client, run_id: str, console: Console) -> None:
    """Stop the run if it has begun; asked of the service, for it may have begun a moment ago."""
    runs = next(message for message in client.get("state") if message["type"] == "runs")["runs"]
    if any(run["id"] == run_id and run["state"] == "running" for run in runs):
        client.post("stop", {"by": client.person})
        console.print("STOP was sent: the bench should come to rest.")
    else:
        console.print("The run stays in the queue; it can be taken out on the page.")


def _show(bar: Progress, row: Any, message: dict[str, Any]) -> None:
    if message["type"] == "plan":
        bar.update(row, total=message["duration_s"])
    elif message["type"] == "status" and message.get("remaining_s") is not None:
        total = bar.tasks[0].total or 1.0
        left = message["remaining_s"]
        bar.update(row, completed=total - left, description=f"{duration_text(left)} left  {message['label']}")


def _report_end(run: dict[str, Any], console: Console, as_json: bool) -> ExitCode:
    end = run["end"]
    if as_json:
        say(json.dumps({"folder": run["folder"], "run": run["id"], **end}, ensure_ascii=False))
    else:
        made = count_text(end.get("recordings", 0), "recording")
        console.print(f"[bold]{made}[/] in [bold]{escaped(run['folder'])}[/]", soft_wrap=True)
        for sentence in filter(None, [end.get("text"), *end.get("failed", [])]):
            console.print(f"[yellow]{escaped(sentence)}[/]", soft_wrap=True)
    if end.get("cause") == "LimitError":
        return ExitCode.LIMIT
    if end["kind"] == "tripped":
        return exit_code_of_stop(Cause.__members__.get(str(end.get("cause")), Cause.NONE))
    return _CODES.get(end["kind"], ExitCode.INTERNAL_ERROR)
