"""``bench serve``: the service and the operator's page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say

_HELP = """Start the service and the operator's page; a run continues when the page is closed.

The page is at the address printed. Runs go into folders below --folder, one at a time, each in a separate process.
Any address other than 127.0.0.1 needs TLS and a token. [bold]bench run[/] joins the queue of a service for the same
bus.

Examples: [bold]bench serve[/], [bold]bench serve --bench lab.toml --bus eth1[/],
[bold]bench serve --host 0.0.0.0 --name bench.lab --tls-certificate c.pem --tls-key k.pem --token-file token[/]
"""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="serve", help=_HELP)(serve)


def serve(
    bench: Annotated[str, typer.Option("--bench", help="Name of a shipped bench, or path of a file.")] = "rh380n",
    bus: Annotated[
        str | None, typer.Option("--bus", help="Network interface: run through SOEM on real frames.")
    ] = None,
    folder: Annotated[Path, typer.Option("--folder", help="Where campaigns go, each in a folder.")] = Path(
        "recordings"
    ),
    campaigns: Annotated[
        Path | None, typer.Option("--campaigns", help="Folder of campaign files offered beside the shipped ones.")
    ] = None,
    model: Annotated[
        Path | None, typer.Option("--model", help="Simulation file (model.json) drawn over the order spectrum.")
    ] = None,
    host: Annotated[str, typer.Option("--host", help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", min=1, max=65535)] = 8080,
    name: Annotated[
        list[str] | None, typer.Option("--name", help="Host name browsers use; may be given several times.")
    ] = None,
    certificate: Annotated[Path | None, typer.Option("--tls-certificate", help="PEM file.")] = None,
    key: Annotated[Path | None, typer.Option("--tls-key", help="PEM file.")] = None,
    token_file: Annotated[
        Path | None, typer.Option("--token-file", help="File with the secret browsers have to show; made if absent.")
    ] = None,
    notify: Annotated[
        list[str] | None,
        typer.Option("--notify", help="apprise address alarms are sent to; several times for several."),
    ] = None,
    stop_port: Annotated[
        int,
        typer.Option("--stop-port", min=0, max=65535, help="Port of the stop listener of the runs; 0 for a free one."),
    ] = 0,
    conceal: Annotated[
        int | None,
        typer.Option(
            min=0, help="Emulated bench: seed of a plant with concealed physics; bench prove --open reveals it."
        ),
    ] = None,
    watch: Annotated[
        bool,
        typer.Option("--watch", help="Hardware: read the bench without torque while nothing runs; its bus is locked."),
    ] = False,
    systemd_unit: Annotated[
        bool, typer.Option("--systemd-unit", help="Print the systemd unit for these options and end.")
    ] = False,
) -> None:
    """Start the service (the help text stands in _HELP)."""
    from bench.service.settings import Settings

    settings = Settings(
        bench=bench,
        interface=bus,
        folder=folder,
        campaigns=campaigns,
        host=host,
        port=port,
        token=None if token_file is None else _token(token_file),
        certificate=certificate,
        key=key,
        names=tuple(name or ()),
        model=model,
        notify=tuple(notify or ()),
        stop_port=stop_port,
        conceal=conceal,
        watch=watch,
    )
    if systemd_unit:
        _print_unit()
        return
    from bench.service.server import run

    run(settings)


def _token(path: Path) -> str:
    """Read the token, or make one only its owner can read."""
    import os
    import secrets

    from bench.errors import ConfigurationError

    if not path.exists():
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with open(descriptor, "w", encoding="utf-8") as file:
            file.write(secrets.token_urlsafe(24) + "\n")
    token = path.read_text("utf-8").strip()
    if not token:
        raise ConfigurationError(
            f"{path} is empty; remove it and a token is made, or write one of 16 characters or more"
        )
    return token


def _print_unit() -> None:
    import getpass
    import sys

    from bench.service.unit import unit

    arguments = [word for word in sys.argv[sys.argv.index("serve") + 1 :] if word != "--systemd-unit"]
    say(unit(arguments, Path.cwd(), getpass.getuser()), nl=False)
