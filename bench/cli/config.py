"""``bench config``: show and validate a bench file."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from bench.cli._plain import PlainConsole, escaped, say


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="config")(config)


def config(
    bench: Annotated[str, typer.Argument(help="Name of a shipped bench, or path of a bench file.")] = "rh380n",
    list_benches: Annotated[bool, typer.Option("--list", help="List the benches that come with the program.")] = False,
    as_toml: Annotated[bool, typer.Option("--toml", help="Print the file itself, to start one of your own.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print all values in SI units as JSON.")] = False,
) -> None:
    """Check a bench file and show its values.

    A wrong file is refused with the key, its value, the reason and what would be right. Start your own bench with
    [bold]bench config rh380n --toml > mine.toml[/] and check it with [bold]bench config mine.toml[/].
    """
    from rich.table import Table

    from bench.configuration import load_bench, shipped_benches

    console = PlainConsole()
    if list_benches:
        names = {name: load_bench(name).configuration.title for name in shipped_benches()}
        if as_json:
            say(json.dumps(names, ensure_ascii=False))
        else:
            for name, title in names.items():
                console.print(f"[bold]{escaped(name)}[/]  {escaped(title)}")
        return
    file = load_bench(bench)
    if as_toml:
        say(file.text, nl=False)
        return
    data = file.configuration.model_dump(mode="json")
    if as_json:
        say(json.dumps(data, ensure_ascii=False))
        return
    table = Table("key", "value (SI, °C)", title=f"{file.origin}: valid", title_justify="left")
    for key, value in _flat(data, ""):
        table.add_row(escaped(key), escaped(value))
    console.print(table)


def _flat(data: object, prefix: str) -> list[tuple[str, object]]:
    if isinstance(data, dict):
        return [row for key, value in data.items() for row in _flat(value, f"{prefix}.{key}" if prefix else key)]
    if isinstance(data, list):
        return [row for index, value in enumerate(data) for row in _flat(value, f"{prefix}[{index + 1}]")]
    return [(prefix, data)]
