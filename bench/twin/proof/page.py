"""The stored result as tables of the page docs/twin.md, between two marks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bench.proof.marked import between, table
from bench.proof.statistics import clopper_pearson
from bench.twin.proof.campaigns import STRENGTHS, WITHOUT

BEGIN, END = "<!-- twin tables -->", "<!-- /twin tables -->"
Rows = Sequence[Mapping[str, Any]]


def tables(content: Mapping[str, Any]) -> str:
    """False alarms, then delay and misses by change and strength, then what was reported, then the cost."""
    rows: Rows = content["campaigns"]
    lines = [
        *_false_alarms(rows),
        "",
        *_detection_table(rows),
        "",
        *_report_table(rows),
        "",
        *_cost(rows),
        *_at_its_rate(content),
    ]
    made = sorted({f"{row['commit'][:12]}{'+changes' * row['commit'].endswith('+changes')}" for row in rows})
    done = f"{len(rows)} campaigns run of those of `{content['command']}`, commit {', '.join(made) or 'none'}."
    return "\n".join([*lines, "", done])


def insert_tables(page: str, content: Mapping[str, Any]) -> str:
    """The page with new tables between its marks; at its end where it has none."""
    return between(page, BEGIN, END, tables(content))


def _share(hits: int, trials: int) -> str:
    if trials == 0:
        return "not run"
    low, high = clopper_pearson(hits, trials)
    return f"{hits} of {trials} ({100.0 * low:.1f} to {100.0 * high:.1f} %)"


def _false_alarms(rows: Rows) -> list[str]:
    """Alarms before anything began."""
    without = [row for row in rows if row["change"] == WITHOUT]
    early = [row for row in rows if row["change"] != WITHOUT]
    wrong = sum(row["noticed"] is not None for row in without)
    before = sum(row["noticed"] is not None and row["noticed"] < row["began"] for row in early)
    highest = max((row["strongest"] for row in without), default=None)
    out = table(
        ["campaigns", "false alarms (95 % interval)"],
        [
            ["without a change", _share(wrong, len(without))],
            ["with one, alarm before it began", _share(before, len(early))],
        ],
    )
    if highest is not None:
        out += ["", f"Strongest evidence (natural logarithm) without a change: {highest:.2f}; the alarm is at 4.83."]
    return out


def _detection_table(rows: Rows) -> list[str]:
    cells = []
    changes = list(dict.fromkeys(row["change"] for row in rows if row["change"] != WITHOUT))
    for level in STRENGTHS:
        for change in [*sorted(changes), "all"]:
            matching = [row for row in rows if row["level"] == level and change in (row["change"], "all")]
            matching = [row for row in matching if row["noticed"] is None or row["noticed"] >= row["began"]]
            delays = sorted(row["noticed"] - row["began"] + 1 for row in matching if row["noticed"] is not None)
            after = [row["points"] - row["began"] for row in matching]
            cells.append([
                level,
                change,
                _delay(delays) if matching else "not run",
                _share(len(matching) - len(delays), len(matching)),
                f"{min(after)} to {max(after)}" if after else "",
            ])  # fmt: skip
    head = ["strength", "what begins", "delay in points, median (range)", "missed (95 % interval)", "points after it"]
    return table(head, cells)


def _delay(delays: Sequence[int]) -> str:
    return f"{np.median(delays):.0f} ({delays[0]} to {delays[-1]})" if delays else "none was seen"


def _report_table(rows: Rows) -> list[str]:
    seen = [row for row in rows if row["noticed"] is not None and row["began"] is not None]
    seen = [row for row in seen if row["noticed"] >= row["began"]]
    if not seen:
        return ["No change was seen."]
    off = [abs(row["told_since"] - row["began"]) for row in seen]
    right = sum(row["channel"] == row["true_channel"] for row in seen)
    return table(
        ["of the changes seen", ""],
        [
            ["reported in the channel where it is strongest", _share(right, len(seen))],
            ["reported to begin within 2 points of the true start", _share(sum(o <= 2 for o in off), len(off))],
            ["points between, median (largest)", f"{np.median(off):.0f} ({max(off)})"],
        ],
    )


def _cost(rows: Rows) -> list[str]:
    looks = [row["look_s"] for row in rows if row["look_s"] is not None]
    if not looks:
        return ["No look was timed."]
    longest = max(row["longest_look_s"] for row in rows if row["longest_look_s"] is not None)
    return [
        f"Processor time of a look at one recording (200 Hz, a revolution): median {np.median(looks):.2f} s, "
        f"longest {longest:.2f} s."
    ]


def _at_its_rate(content: Mapping[str, Any]) -> list[str]:
    """The cost on recordings of the bench itself, where it was measured."""
    cost = content.get("cost")
    if not cost:
        return []
    return [
        "",
        f"At {cost['sample_rate'] / 1000.0:g} kHz ({cost['recordings']} recordings of the emulated bench, "
        f"{cost['recorded_s'] / 60.0:.1f} min): {100.0 * cost['share']:.1f} % of a core at real time; longest look "
        f"{cost['longest_s']:.2f} s of processor time, the first, which calibrates on all before it, "
        f"{cost['first_s']:.2f} s.",
    ]
