"""The stored result as tables of the page docs/investigate.md, between two marks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bench.investigate.proof.run import ASKED, EXPERIMENTS, GRID, OPEN, RANDOM, RIGHT, UNSEEN, WAYS, WRONG
from bench.proof.marked import between, table
from bench.proof.statistics import clopper_pearson

BEGIN, END = "<!-- investigate tables -->", "<!-- /investigate tables -->"
Rows = Sequence[Mapping[str, Any]]
WORDS = {ASKED: "designed", RANDOM: "as many points at random", GRID: "as many points of the grid again"}


def tables(content: Mapping[str, Any]) -> str:
    """Ways side by side, then every plant."""
    rows: Rows = content["campaigns"]
    plants = len({(row["seed"], row["case"]) for row in rows})
    made = sorted({f"{row['commit'][:12]}{'+changes' * row['commit'].endswith('+changes')}" for row in rows})
    done = f"{plants} of {content.get('asked', 0)} plants done of those of `{content['command']}`"
    return "\n".join([*_ways(rows), "", *_plants(rows), "", f"{done}, commit {', '.join(made) or 'none'}."])


def insert_tables(page: str, content: Mapping[str, Any]) -> str:
    """The page with new tables between its marks; at its end where it has none."""
    return between(page, BEGIN, END, tables(content))


def _share(hits: int, trials: int) -> str:
    if trials == 0:
        return "not run"
    low, high = clopper_pearson(hits, trials)
    return f"{hits} of {trials} ({100.0 * low:.0f} to {100.0 * high:.0f} %)"


def _ways(rows: Rows) -> list[str]:
    """Plants that the first campaign left open, for those are the question; then all plants, as they end."""
    cells = []
    for way in WAYS:
        every = [row for row in rows if row["way"] == way]
        left_open = [row for row in every if row["first"] == OPEN]
        hours = [
            row["hours_to_name"] for row in left_open if row["result"] == RIGHT and row["hours_to_name"] is not None
        ]
        cells.append([
            WORDS[way],
            *(_share(sum(row["result"] == result for row in left_open), len(left_open)) for result in (RIGHT, WRONG)),
            f"{np.median(hours):.2f} ({min(hours):.2f} to {max(hours):.2f})" if hours else "none",
            f"{np.mean([row['hours'] for row in left_open]):.2f}" if left_open else "not run",
            *(_share(sum(row["result"] == result for row in every), len(every)) for result in (RIGHT, WRONG)),
        ])  # fmt: skip
    head = [
        f"experiments, {EXPERIMENTS} at most",
        "rightly named (95 % interval)",
        "wrongly named",
        "h of bench time to a right name, median (range)",
        "h run, mean of all",
        "of all plants: rightly named",
        "wrongly named",
    ]
    first = [row["first"] for row in {(row["seed"], row["case"]): row for row in rows}.values()]
    text = (
        f"After the first campaign alone: {first.count(OPEN)} of {len(first)} plants open (the first five columns are "
        f"of these), {first.count(RIGHT)} rightly named, {first.count(WRONG)} wrongly; in {first.count(UNSEEN)} "
        "nothing was found in the channel of the effect, which leaves no question there."
    )
    return [text, "", *table(head, cells)]


def _plants(rows: Rows) -> list[str]:
    cells = []
    for seed, case in sorted({(row["seed"], row["case"]) for row in rows}):
        by_way = {row["way"]: row for row in rows if (row["seed"], row["case"]) == (seed, case)}
        one = next(iter(by_way.values()))
        outcomes = [_outcome(by_way[way]) if way in by_way else "not run" for way in WAYS]
        cells.append([f"{seed}/{case[-1]}", one["effect"], ", ".join(one["also"]), one["first"], *outcomes])
    return table(["plant", "concealed", "confused with", "first campaign", *(WORDS[way] for way in WAYS)], cells)


def _outcome(row: Mapping[str, Any]) -> str:
    hours = row["hours_to_name"] if row["hours_to_name"] is not None else row["hours"]
    return f"{row['result']}, {row['needed'] or row['experiments']} experiments, {hours:.2f} h"
