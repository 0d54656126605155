"""``bench export-model``: a simulation file for other people's tools."""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say


class Form(StrEnum):
    """Languages and formats that can be written."""

    PYTHON = "python"
    C = "c"
    MODELICA = "modelica"
    FMU = "fmu"


class Fmi(StrEnum):
    """Versions of FMI."""

    TWO = "2.0"
    THREE = "3.0"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="export-model")(export_model)


def export_model(
    model: Annotated[Path, typer.Argument(help="Simulation file (model.json).", metavar="MODEL")],
    form: Annotated[Form, typer.Option("--to", help="What to write.")],
    out: Annotated[Path, typer.Option("--out", help="Folder the files go to; it is made if need be.")] = Path("."),
    fmi: Annotated[Fmi, typer.Option("--fmi", help="Version of an FMU (co-simulation).")] = Fmi.THREE,
    standstill: Annotated[
        float, typer.Option("--standstill", min=0.0, help="Motor speed in rad/s below which it stands.")
    ] = 1e-3,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print files, inputs, outputs and parameters as JSON.")
    ] = False,
) -> None:
    """Write a simulation with everything that was found in it: source in Python, C or Modelica, or an FMU.

    Outputs are called simulated_NAME after the channels, inputs as the channels are; coefficients are parameters.
    An FMU contains C that is compiled on this computer; without a compiler, use --to c.
    """
    from bench.exchange.export import WRITERS
    from bench.exchange.written import formulas_of
    from bench.simulation import Simulation

    formulas = formulas_of(Simulation.load(model), standstill)
    files = WRITERS[form.value](formulas, out, model.stem, fmi.value)
    if as_json:
        result = {
            "files": [str(f) for f in files],
            "inputs": list(formulas.inputs),
            "outputs": list(formulas.outputs),
            "parameters": {p.name: p.value for p in formulas.parameters},
            "refused": list(formulas.refused),
            "notes": list(formulas.notes),
        }
        say(json.dumps(result, ensure_ascii=False))
        return
    say(f"{', '.join(str(f) for f in files)}: {', '.join(formulas.outputs)} from {', '.join(formulas.inputs)}")
    for sentence in (*formulas.refused, *formulas.notes):
        say(f"note: {sentence}")
