"""``bench benchmark twin``: how soon the twin sees a change, and how often it sees one that is not there."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import typer

from bench.cli._plain import say
from bench.cli._stored import load_stored
from bench.cli._stored import store as keep

FORMAT, FORMAT_VERSION = "bench-twin", "1.0"


def twin(
    campaigns: Annotated[int, typer.Option("--campaigns", min=0, help="How many with a change.")] = 60,
    without: Annotated[int, typer.Option("--without", min=0, help="How many without one.")] = 100,
    work: Annotated[Path, typer.Option("--work", help="Folder of the models; what is there is used.")] = Path("twin"),
    store: Annotated[
        Path | None, typer.Option("--store", help="Keep results here; later runs go on from them.")
    ] = None,
    table: Annotated[Path | None, typer.Option("--table", help="Write the tables into this page of Markdown.")] = None,
    picture: Annotated[Path | None, typer.Option("--picture", help="PNG: the first campaign with a change.")] = None,
    cost: Annotated[
        Path | None, typer.Option("--cost", help="Folder of recordings: measure what looking at them costs.")
    ] = None,
    model: Annotated[Path | None, typer.Option("--model", help="With --cost: the model that watches them.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Watch generated campaigns with the twin: in some a change begins in the middle, in the others nothing changes.

    Each recording is written to a file and compared as in a running campaign; no bus is involved. It can be stopped
    and run again at any time.
    """
    from bench.proof.results import commit
    from bench.twin.proof.campaigns import WITHOUT, cases, run
    from bench.twin.proof.page import insert_tables, tables

    # of the program that is running: others may commit meanwhile
    made_by = commit()
    content = load_stored(store, {"format": FORMAT, "format_version": FORMAT_VERSION, "command": "", "campaigns": []})
    if campaigns or without:
        content["command"] = f"bench benchmark twin --campaigns {campaigns} --without {without}"
    done = {row["key"]: row for row in content["campaigns"]}
    listed = cases(campaigns, without)
    work.mkdir(parents=True, exist_ok=True)
    for number, case in enumerate(listed, 1):
        if case.key in done:
            continue
        about = {"commit": made_by, "day": datetime.now(UTC).date().isoformat()}
        done[case.key] = run(case, work) | about
        content["campaigns"] = [done[listed_case.key] for listed_case in listed if listed_case.key in done]
        keep(store, content)
        if not as_json:
            say(f"campaign {number} of {len(listed)}: {case.change}")
    if cost is not None:
        content["cost"] = _cost(model, cost)
        keep(store, content)
    if table is not None:
        table.write_text(insert_tables(table.read_text("utf-8") if table.exists() else "", content), "utf-8")
    if picture is not None:
        from bench.errors import BenchError
        from bench.twin.proof.picture import draw

        first = next((row for row in content["campaigns"] if row["change"] != WITHOUT), None)
        if first is None:
            raise BenchError("--picture draws a campaign with a change; ask for one with --campaigns.")
        draw(first, picture)
    say(json.dumps(content, ensure_ascii=False) if as_json else tables(content))


def _cost(model: Path | None, folder: Path) -> dict[str, Any]:
    from bench.errors import ConfigurationError
    from bench.twin.proof.cost import cost

    if model is None:
        raise ConfigurationError("--cost asks for the model that watches; give one with --model model.json")
    return cost(model, folder)
