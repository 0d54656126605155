"""``bench acknowledge`` and ``bench reset``: what an operator does after a stop, before ``bench run --resume``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.cli._plain import say

if TYPE_CHECKING:
    from bench.configuration import BenchFile
    from bench.safety import Latch

_FOLDER = Annotated[
    Path | None, typer.Argument(help="Folder of the run that was stopped; not needed for a bench behind --bus.")
]
_BENCH = Annotated[str, typer.Option("--bench", help="Name of a shipped bench, or path of a file.")]
_BUS = Annotated[str | None, typer.Option("--bus", help="Network interface of the bench, as for bench run.")]
_JSON = Annotated[bool, typer.Option("--json", help="Print the latch as JSON, nothing else.")]


def register(app: typer.Typer) -> None:
    """Add both commands."""
    app.command(name="acknowledge")(acknowledge)
    app.command(name="reset")(reset)


def acknowledge(folder: _FOLDER = None, bench: _BENCH = "rh380n", bus: _BUS = None, as_json: _JSON = False) -> None:
    """Confirm that you have read why the bench stopped.

    The first of three acts after a stop: acknowledge, reset, bench run --resume. Only the last one gives torque again.
    """
    from bench.cli._operator import somebody
    from bench.safety import acts

    file, run = _bench_and_run(folder, bench, bus)
    standing = acts.latch_of(file, run).read()
    why = standing.text.rstrip(".") or "no"
    by = somebody(file.configuration, "acknowledge", f"The bench was stopped: {why}. Acknowledge?")
    _print(acts.acknowledge(file, run, by), folder, as_json)


def reset(folder: _FOLDER = None, bench: _BENCH = "rh380n", bus: _BUS = None, as_json: _JSON = False) -> None:
    """Reset the drives' faults and check whether the cause of the stop is gone; no torque is given.

    The second of three acts after a stop. Without a stop it resets faults that the drives show already.
    """
    from bench.campaigns.operator.reset import reset as reset_bench
    from bench.cli._operator import somebody
    from bench.locks import bus_in_use

    file, run = _bench_and_run(folder, bench, bus)
    by = somebody(file.configuration, "reset", "Is the cause gone, and may the drives lose their faults?")
    with bus_in_use(file):
        latch = reset_bench(file, run, by)
    _print(latch, folder, as_json)


def _bench_and_run(folder: Path | None, bench: str, bus: str | None) -> tuple[BenchFile, Path]:
    from bench.configuration import load_bench, on_interface
    from bench.errors import ConfigurationError

    file = load_bench(bench)
    if bus is not None:
        file = on_interface(file, bus)
    if folder is None and file.configuration.bus.in_process:
        raise ConfigurationError("which run was stopped? Give its folder, or --bus for a bench on an interface")
    if folder is not None and not folder.is_dir():
        raise ConfigurationError(f"{folder}: there is no such folder; give that of the run that was stopped")
    return file, folder or Path()


def _print(latch: Latch, folder: Path | None, as_json: bool) -> None:
    from bench.safety.latch import HOW, NEXT, Act

    if as_json:
        say(json.dumps(latch.as_dict(), ensure_ascii=False))
        return
    due = NEXT[latch.standing]
    if due is None:
        say(f"{latch.standing.value}; nothing is latched")
        return
    place = "" if folder is None else f" --out {folder}" if due is Act.RESUME else f" {folder}"
    say(f"{latch.standing.value}; next is {HOW[due]}{place}")
