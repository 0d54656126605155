"""``bench compensate``: the model's feedforward tried on the emulated bench, and the model as a C function."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.cli._plain import PlainConsole, say
from bench.errors import BenchError

if TYPE_CHECKING:
    from bench.campaigns.compensation import OperatingPoint

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
        Path | None, typer.Option("--c", help="Write the model as C source with its own test into this folder.")
    ] = None,
    run: Annotated[bool, typer.Option("--run/--no-run", help="Try the feedforward on the emulated bench.")] = True,
    seed: Annotated[int, typer.Option(help="Seed of the emulated plant's noise.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Send the motor to q_d − TE instead of q_d and compare the error of the load side with and without.

    The error is q − q_d over one revolution; its mean, its trend and the load motor's ripple are taken off.
    """
    from rich.table import Table

    from bench.campaigns.compensation import compensate as run_points
    from bench.configuration import load_bench
    from bench.identification.c_export import export_c
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
                load_bench(bench), simulation, points, seed=seed, runs=runs, progress=lambda text: status.update(text)
            )
    if as_json:
        rows = [
            {
                "load_torque": o.point.load_torque,
                "velocity": o.point.velocity,
                "temperature": o.temperature,
                "rmse": o.rmse,
            }
            for o in outcomes
        ]
        say(json.dumps({"points": rows, "files": [str(path) for path in written]}))
        return
    if outcomes:
        table = Table(title="RMS of q − q_d in µrad")
        for heading in ("load torque", "velocity", "temperature", *outcomes[0].rmse, "left"):
            table.add_column(heading, justify="right")
        for o in outcomes:
            cells = [f"{1e6 * value:.2f}" for value in o.rmse.values()]
            at = (
                f"{o.point.load_torque:g} N·m",
                f"{math.degrees(o.point.velocity):g} deg/s",
                f"{o.temperature:.1f} °C",
            )
            table.add_row(*at, *cells, f"{100 * o.rmse['with'] / o.rmse['without']:.0f} %")
        console.print(table)
    for path in written:
        console.print(f"{path}", markup=False)
    if written:
        console.print("Test: cc -std=c99 -O2 transmission_error.c test_transmission_error.c -lm -o test && ./test")


def _point(text: str) -> OperatingPoint:
    from bench.campaigns.compensation import OperatingPoint

    try:
        torque, velocity = (float(part) for part in text.split(","))
    except ValueError as error:
        raise BenchError(f"--point is '{text}', it should be load torque and velocity such as 700,6.") from error
    if velocity == 0.0:
        raise BenchError(f"--point is '{text}', its velocity should not be 0.")
    return OperatingPoint(torque, math.radians(velocity))
