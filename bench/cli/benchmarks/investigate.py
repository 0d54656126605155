"""``bench benchmark investigate``: how often, and in how many hours, the bench that asks comes to the right name."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from bench.cli._plain import say
from bench.cli._stored import load_stored
from bench.cli._stored import store as keep

FORMAT, FORMAT_VERSION = "bench-investigate", "1.0"


def investigate(
    plants: Annotated[int, typer.Option("--plants", min=0, help="How many hidden plants.")] = 50,
    seed: Annotated[int, typer.Option("--seed", help="Of the first nine plants; the next nine have the next.")] = 1701,
    store: Annotated[
        Path | None, typer.Option("--store", help="Keep results here; later runs go on from them.")
    ] = None,
    table: Annotated[Path | None, typer.Option("--table", help="Write the tables into this page of Markdown.")] = None,
    picture: Annotated[Path | None, typer.Option("--picture", help="PNG: hours to a right name, way by way.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Conceal physics that the first campaign leaves open, and investigate it in three ways: with designed experiments,
    as many random points, as many points of the first grid.

    It can be stopped and run again at any time; a plant counts when all three are done.
    """
    from bench.investigate.proof.page import insert_tables, tables
    from bench.investigate.proof.plants import cases
    from bench.investigate.proof.run import run
    from bench.proof.results import commit

    made_by = commit()
    content = load_stored(store, {"format": FORMAT, "format_version": FORMAT_VERSION, "command": "", "campaigns": []})
    content |= {"command": f"bench benchmark investigate --plants {plants} --seed {seed}", "asked": plants}
    each = len(cases(seed))
    for number in range(plants):
        case_seed = seed + number // each
        case = cases(case_seed)[number % each]
        if any((row["seed"], row["case"]) == (case_seed, case.name) for row in content["campaigns"]):
            continue
        about = {"commit": made_by, "day": datetime.now(UTC).date().isoformat()}
        report_progress = (lambda _: None) if as_json else say
        content["campaigns"] += [row | about for row in run(case, case_seed, report_progress)]
        keep(store, content)
    if table is not None:
        table.write_text(insert_tables(table.read_text("utf-8") if table.exists() else "", content), "utf-8")
    if picture is not None:
        from bench.investigate.proof.picture import draw

        draw(content, picture)
    say(json.dumps(content, ensure_ascii=False) if as_json else tables(content))
