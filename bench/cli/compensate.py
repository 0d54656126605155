"""``bench compensate``: the model's feedforward tried on the emulated bench, and the model as a C function."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.cli._plain import PlainConsole, say
from bench.cli.identify import parse_orders
from bench.errors import BenchError
from bench.whole import write_whole

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bench.campaigns.compensation import OperatingPoint, Outcome

DEFAULT_POINTS = ("700,6", "-250,-8.5", "150,4")
"""Load torque N·m and velocity deg/s; none of the paper campaign's identification points."""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="compensate")(compensate)


def compensate(
    model: Annotated[Path, typer.Argument(help="A simulation file with an identified transmission error.")],
    bench: Annotated[str, typer.Option("--bench", help="Name or path of an emulated bench.")] = "rh380n",
    point: Annotated[
        list[str] | None,
        typer.Option("--point", help="Load torque in N·m and velocity in deg/s, such as 700,6; can be given often."),
    ] = None,
    added: Annotated[
        bool, typer.Option("--added", help="Also run with the error added, as the paper's figure has it.")
    ] = False,
    c_code: Annotated[
        Path | None, typer.Option("--c", help="Write the model as C source, with a test, into this folder.")
    ] = None,
    run: Annotated[bool, typer.Option("--run/--no-run", help="Try the feedforward on the emulated bench.")] = True,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the emulated plant's noise.")] = 0,
    loop: Annotated[
        str | None,
        typer.Option(
            "--loop",
            help="The input drive's velocity loop, to allow for it: gain N·m·s/rad, integral time s: 0.6,0.02.",
        ),
    ] = None,
    notch: Annotated[
        str,
        typer.Option(
            "--notch",
            help="Orders of the load motor's ripple, which are subtracted because they are not the gearbox's.",
        ),
    ] = "150,300",
    table: Annotated[Path | None, typer.Option("--table", help="Write the table as Markdown.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Command the motor angle q_d − TE instead of q_d, and compare the error of the load side with and without.

    The error is q − q_d over one revolution, without its mean, its trend and the load motor's ripple. The speed
    ripple is its rate. "With / counting" is relative to the error that the whole counts of the motor encoder cause.
    """
    from rich.table import Table

    from bench.campaigns.compensation import compensate as run_points
    from bench.configuration import load_bench
    from bench.identification.compensation.c_export import export_c
    from bench.simulation import Simulation

    simulation = Simulation.load(model)
    points = [_point(text) for text in point or DEFAULT_POINTS]
    written = export_c(simulation, c_code) if c_code is not None else ()
    console = PlainConsole(stderr=as_json, highlight=False)
    outcomes = []
    if run:
        runs = ("without", "with", "added") if added else ("without", "with")
        with console.status("starting") as status:
            outcomes = run_points(
                load_bench(bench),
                simulation,
                points,
                seed=seed,
                runs=runs,
                notch_orders=parse_orders(notch, "--notch") if notch else (),
                loop=None if loop is None else _loop(loop),
                progress=lambda text: status.update(text),
            )
    if table is not None and outcomes:
        write_whole(table, markdown(outcomes))
    if as_json:
        say(json.dumps({"points": [_row(o) for o in outcomes], "files": [str(path) for path in written]}))
        return
    if outcomes:
        shown = Table(title="RMS of q − q_d in µrad, and of the load side's speed ripple in mrad/s")
        for heading in _headings(outcomes):
            shown.add_column(heading, justify="right")
        for o in outcomes:
            shown.add_row(*_cells(o))
        console.print(shown)
    for path in written:
        console.print(f"{path}", markup=False)
    if written:
        console.print("Test: cc -std=c99 -O2 transmission_error.c test_transmission_error.c -lm -o test && ./test")


def _loop(text: str) -> tuple[float, float]:
    try:
        gain, integral_time = (float(part) for part in text.split(","))
    except ValueError as error:
        raise BenchError(f"--loop is '{text}', it should be gain and integral time such as 0.6,0.02.") from error
    if not (gain > 0.0 and integral_time > 0.0):
        raise BenchError(f"--loop is '{text}', gain and integral time should be above 0.")
    return gain, integral_time


def _row(o: Outcome) -> dict[str, Any]:
    return {
        "load_torque": o.point.load_torque,
        "velocity": o.point.velocity,
        "temperature": o.temperature,
        "rmse": {name: left.rmse for name, left in o.left.items()},
        "speed": {name: left.speed for name, left in o.left.items()},
        "counting": o.counting,
    }


def _headings(outcomes: Sequence[Outcome]) -> list[str]:
    names = list(outcomes[0].left)
    return ["point", *(f"q − q_d {n}" for n in names), "with / counting", *(f"speed {n}" for n in names), "speed left"]


def _cells(o: Outcome) -> list[str]:
    plain, taken = o.left["without"], o.left["with"]
    return [
        f"{o.point.load_torque:g} N·m, {math.degrees(o.point.velocity):g} deg/s, {o.temperature:.1f} °C",
        *(f"{1e6 * left.rmse:.2f}" for left in o.left.values()),
        f"{taken.rmse / o.counting:.2f}",
        *(f"{1e3 * left.speed:.3f}" for left in o.left.values()),
        f"{100 * taken.speed / plain.speed:.0f} %",
    ]


def markdown(outcomes: Sequence[Outcome]) -> str:
    """Return the table as Markdown: µrad and mrad/s, RMS."""
    head = _headings(outcomes)
    rows = [head, ["---"] * len(head), *(_cells(o) for o in outcomes)]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows) + "\n"


def _point(text: str) -> OperatingPoint:
    from bench.campaigns.compensation import OperatingPoint

    try:
        torque, velocity = (float(part) for part in text.split(","))
    except ValueError as error:
        raise BenchError(f"--point is '{text}', it should be load torque and velocity such as 700,6.") from error
    if velocity == 0.0:
        raise BenchError(f"--point is '{text}', its velocity should not be 0.")
    return OperatingPoint(torque, math.radians(velocity))
