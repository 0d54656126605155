"""``bench commission``: try a bench out, step by step, before it may run."""

from __future__ import annotations

import getpass
import json
import sys
from dataclasses import asdict
from typing import Annotated

import typer

from bench.cli._plain import say
from bench.errors import LimitError

_HELP = """Commission a bench: slaves, limits in the drives, safety circuits, tare, brakes, signs, the encoders' zero.

Every step first prints what it will do. Nothing moves before you have confirmed that everybody is clear; motion is
slow, with a fraction of the torque. A bench behind a network interface does not run before it has passed, and after a
change of its parts, bus or limits not before it has passed again. After every power cut [bold]--zero[/] finds the
encoders' zero again.

On a bench emulated in this process it is a rehearsal: such a bench is new each time and needs no record.

Example: [bold]bench commission --bench lab.toml --bus eth1[/]
"""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="commission", help=_HELP)(commission)


class _Terminal:
    """A person at a terminal."""

    has_hands = True

    def step(self, number: int, count: int, title: str, what: str) -> None:
        """Print the step's heading."""
        say(f"{number}/{count} {title}: {what}", err=True)

    def ask(self, question: str) -> bool:
        """Ask; no is the default."""
        return typer.confirm(f"    {question}", err=True)

    def show(self, text: str) -> None:
        """Print."""
        say(f"    {text}", err=True)


class _Emulated(_Terminal):
    """Nobody: the plant is emulated, and every question is answered with yes."""

    has_hands = False

    def ask(self, question: str) -> bool:
        """Print the question and say yes."""
        say(f"    {question} Yes, it is emulated.", err=True)
        return True


def commission(
    bench: Annotated[str, typer.Option("--bench", help="Name of a shipped bench, or path of a file.")] = "rh380n",
    bus: Annotated[str | None, typer.Option("--bus", help="Network interface of the bench, as for bench run.")] = None,
    zero: Annotated[
        bool, typer.Option("--zero", help="Only find the encoders' common zero again, as after a power cut.")
    ] = False,
    yes: Annotated[
        bool,
        typer.Option("--yes", help="Answer every question with yes; only if the bench file names an emulated plant."),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the record as JSON.")] = False,
) -> None:
    """Commission (the help text stands in _HELP)."""
    from bench.commissioning import commission as run
    from bench.commissioning.record import record_path
    from bench.configuration import load_bench, on_interface
    from bench.locks import bus_in_use

    file = load_bench(bench)
    if bus is not None:
        file = on_interface(file, bus)
    emulated = file.configuration.bus.plant is not None
    if yes and not emulated:
        raise LimitError("--yes is for emulated plants only (bus.plant); a real bench wants somebody who looks")
    if not yes and not sys.stdin.isatty():
        raise LimitError("commissioning wants a person at a terminal, or --yes where the plant is emulated")
    guide = _Emulated() if yes else _Terminal()
    with bus_in_use(file):
        record = run(file, guide, getpass.getuser() if not yes else f"script of {getpass.getuser()}", only_zero=zero)
    path = record_path(file.configuration)
    if as_json:
        say(json.dumps(asdict(record), ensure_ascii=False))
    else:
        where = "no record is kept: a bench emulated in this process is new every time" if path is None else str(path)
        say(f"passed; zero {record.zero.zero_id}; {where}")
