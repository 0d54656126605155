"""``bench benchmark cycle``: punctuality of the bus process beside a minimal C loop on the same SOEM."""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.cli._plain import PlainConsole, say
from bench.errors import ConfigurationError

if TYPE_CHECKING:
    from bench.cycle.jitter.compare import Comparison
    from bench.cycle.jitter.figures import LoopFigures

_PARTS = (("wake-up", "wake"), ("round trip", "trip"), ("whole cycle", "cycle"))


def cycle(
    seconds: Annotated[float, typer.Option(min=0.5, help="How long each loop cycles at each rate.")] = 10.0,
    rate: Annotated[
        list[float] | None, typer.Option(help="Hz; may be given again.  [default: 1000, 2000, 4000]")
    ] = None,
    interface: Annotated[
        str | None, typer.Option(help="Interface of the master; default: a veth pair is made.")
    ] = None,
    far: Annotated[str | None, typer.Option(help="Interface the emulator is started on, with --interface.")] = None,
    priority: Annotated[
        int, typer.Option(min=0, max=98, help="SCHED_FIFO priority of the masters, the emulator gets 9 less; 0: none.")
    ] = 80,
    cpu: Annotated[int | None, typer.Option(help="Processor of the masters; default: the last one.")] = None,
    emulator_cpu: Annotated[
        int | None, typer.Option(help="Processor of the emulator; default: the one before.")
    ] = None,
    load: Annotated[
        bool, typer.Option("--load", help="HDF5 is written, and an identification runs beside the emulator.")
    ] = False,
    make_up_ms: Annotated[
        float, typer.Option(min=0.0, max=50.0, help="Late cycles of the bus process are begun up to so much later, ms.")
    ] = 0.0,
    without_c: Annotated[bool, typer.Option("--without-c", help="Leave the C loop out.")] = False,
    soem: Annotated[
        Path | None,
        typer.Option(help="pysoem's source distribution, packed or unpacked; default: pip downloads it."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print all figures and histograms as JSON.")] = False,
) -> None:
    """Measure how punctual cycles are over the wire-level emulator: wake-up, round trip, whole cycle.

    The bus process (with the rig behind it) and a minimal C loop on the same SOEM take turns at each rate; the time
    that the host of a virtual machine took away is shown as well. Needs CAP_NET_RAW, to make a veth pair root rights.
    """

    from bench.cycle.jitter.compare import Conditions, compare, default_processors
    from bench.cycle.round_trip import veth_pair

    if (interface is None) != (far is None):
        raise ConfigurationError("--interface and --far are the two ends of one cable: give both or none")
    console = PlainConsole(stderr=True, highlight=False)
    master_cpu, other_cpu = default_processors()
    conditions = Conditions(
        tuple(rate) if rate else (1000.0, 2000.0, 4000.0),
        seconds,
        priority or None,
        master_cpu if cpu is None else cpu,
        other_cpu if emulator_cpu is None else emulator_cpu,
        load,
        make_up_ms / 1e3,
        not without_c,
        soem,
    )
    with ExitStack() as closing:
        near, other = (interface, far) if interface and far else closing.enter_context(veth_pair())
        found = compare(near, other, conditions, lambda text: console.print(f"[dim]{text} …[/]"))
    if as_json:
        say(json.dumps(found.as_dict()))
    else:
        _print(found, conditions.seconds)


def _print(found: Comparison, seconds: float) -> None:
    from rich.table import Table

    console = PlainConsole(highlight=False)
    table = Table(title=f"µs, {seconds:g} s each")
    for name in ("rate", "what", "loop", "median", "99 %", "99.9 %", "maximum"):
        table.add_column(name, justify="left" if name in ("what", "loop") else "right")
    for at in found.rates:
        loops = [("bus process", at.python)] + ([("C on SOEM", at.c)] if at.c is not None else [])
        for text, field in _PARTS:
            for name, loop in loops:
                times = getattr(loop, field)
                numbers = (times.median, times.p99, times.p999, times.maximum)
                table.add_row(f"{at.rate:g} Hz", text, name, *(f"{number:.1f}" for number in numbers))
        table.add_section()
    console.print(table)
    for at in found.rates:
        console.print(f"{at.rate:g} Hz  bus process: {_lost(at.python)}")
        if at.c is not None and at.ratio is not None:
            console.print(f"{' ' * len(f'{at.rate:g}')}     C on SOEM:   {_lost(at.c)}")
            console.print(f"        whole cycle by the C loop's: median {at.ratio[0]:.2f}, 99.9 % {at.ratio[1]:.2f}")
    for note in found.notes:
        console.print(f"note: {note}", soft_wrap=True)


def _lost(loop: LoopFigures) -> str:
    return (
        f"{loop.cycles:,} cycles, {loop.late} began a period late, {loop.missed} slots missed,"
        f" {loop.lost} frames lost, {loop.wrong} wrong counters"
        f" ({loop.beside_stolen} of them within 50 ms of stolen time); the host took {loop.steal_s:.2f} s"
    )
