"""``bench compare``: what changed between two gearboxes, or one before and after wear."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.cli._plain import PlainConsole, say
from bench.errors import ConfigurationError

if TYPE_CHECKING:
    from bench.simulation import Simulation


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="compare")(compare)


def compare(
    before: Annotated[Path, typer.Argument(help="A simulation file (model.json) or a folder of recordings.")],
    after: Annotated[
        Path | None,
        typer.Argument(help="Another one. None: compare a folder before and since the change that its twin reported."),
    ] = None,
    since: Annotated[
        str, typer.Option("--since", help="With one folder: id of the first recording after the change.")
    ] = "",
    everything: Annotated[bool, typer.Option("--all", help="List what did not change too.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the comparison as JSON.")] = False,
) -> None:
    """Compare orders, compliance, friction, heat and load side; only changes beyond their uncertainty count.

    If nothing has changed, at most one comparison in twenty reports a change, over all quantities together.
    """
    from rich.table import Table

    from bench.identification.comparison.compare import compare as compare_simulations
    from bench.identification.comparison.compare import to_json
    from bench.twin.comparison import PARTS, before_and_since, not_judged

    if after is not None and since:
        raise ConfigurationError("--since splits one folder; give one, or two without --since")
    if after is None:
        found = before_and_since(before, since)
        names, changes = PARTS, list(found.changes)
        about = {"before": PARTS[0], "after": PARTS[1], "folder": str(before), "since": found.since}
    else:
        names, changes = (before.name, after.name), compare_simulations(_simulation(before), _simulation(after))
        about = {"before": str(before), "after": str(after)}
    if as_json:
        say(json.dumps(about | {"changes": to_json(changes)}))
        return
    console = PlainConsole(highlight=False, width=120)
    shown = changes if everything else [c for c in changes if c.changed]
    table = Table(title=f"{names[0]} → {names[1]}: {sum(c.changed for c in changes)} of {len(changes)} changed")
    for heading in ("what", "before", "after", "difference", "standard deviation", "unit", "p", "changed"):
        table.add_column(heading, justify="left" if heading in ("what", "unit") else "right")
    for c in shown:
        cells = [
            f"{c.before:.5g}",
            f"{c.after:.5g}",
            f"{c.after - c.before:.3g}",
            f"{c.std:.2g}",
            c.unit,
            f"{c.p_value:.1e}",
        ]
        table.add_row(c.what, *cells, "yes" if c.changed else "no")
    console.print(table)
    left_open = not_judged(changes)
    if left_open:
        console.print(left_open, markup=False)


def _simulation(path: Path) -> Simulation:
    from bench.simulation import Simulation

    if not path.is_dir():
        return Simulation.load(path)
    from bench.identification import Options, identify_folder, to_simulation

    return to_simulation(identify_folder(path, Options()))
