"""Figures of the documentation, made from stored results: what stands there is what was measured, or that it was not.

A page holds blocks ``<!-- proof NAME WHAT -->`` … ``<!-- /proof -->``. What is between is made from
``docs/proof/NAME.json``: its ``table``, its ``line`` for a table of another page, the ``command`` that makes it, or
``all`` of it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from bench.proof import criteria_table, marked
from bench.proof.results import ResultsError, Stored, load
from bench.proof.statistics import summarise
from bench.proof.table import body, severity_lines, summary_rows

RESULTS = Path("docs/proof")
PAGES = (Path("README.md"), Path("docs/proof.md"), Path("docs/criteria.md"))
CRITERIA = "criteria"
"""name of the table of the numbers that decide"""
PEERS = "peers"
"""name of the table of other methods on the same folders"""
#: The examinations that the pages quote, and the command of each.
COMMANDS = {
    "development": "bench prove --set clear,faint,compound,unknown,ambiguous,null,switched_off --seed 5",
    "blind": "bench prove --held-back --set clear,compound,unknown,ambiguous,null --seed NEW",
    "faint": "bench prove --held-back --set faint --count 8 --seed NEW",
    "clutter": "bench prove --clutter --set clear,compound,unknown,null --seed NEW",
    "through": "bench prove --through-the-bench --count 20 --seed NEW",
    "again": "bench prove --through-the-bench --again --count 20 --seed NEW",
    "null": "bench prove --set null --nulls 300 --seed 7",
    "null-small": "bench prove --set null_small --nulls 300 --seed 7",
    "null-clutter": "bench prove --clutter --set null --nulls 100 --seed 8",
    "severity": "bench prove --severity --repeats 3",
    "peers": "bench prove --peers --held-back --set clear,compound,null --count 5 --nulls 5 --seed NEW",
    "quick": "bench prove --quick",
    CRITERIA: "bench prove --criteria --set clear,null --count 1 --seed 3",
}
_BLOCK = re.compile(r"(<!-- proof (?P<name>[a-z-]+) (?P<what>[a-z]+) -->)(?P<body>.*?)(<!-- /proof -->)", re.DOTALL)


def table(stored: Stored) -> str:
    """How it came about, and one row a set."""
    if stored.severity:
        done = f" {len(stored.scores)} of {sum(stored.provenance.asked.values())} folders done."
        lines = severity_lines(stored.scores)
    else:
        done, lines = "", summary_rows(stored.scores, stored.provenance.asked)
    return _below(f"{stored.provenance.summary}.{done}", lines)


def whole(stored: Stored) -> str:
    """The same with everything below it: effects, forms, folders that are not right, calibration."""
    return "\n".join([table(stored).rstrip("\n"), "", *body(stored.scores), ""])


def beside_peers(path: Path) -> str:
    """This program and other methods on the same folders, one row each."""
    stored, content = load(path), json.loads(path.read_text("utf-8"))
    rows = {"bench mismatch": asdict(summarise("all", stored.scores)), **content["peers"]}
    head = ["method", "folders", *_OF_PEERS.values(), "residual / noise (median)", "s a folder"]
    cells = [
        [
            name,
            str(row["cases"]),
            *(f"{row[key][0]}/{row[key][1]}" for key in _OF_PEERS),
            f"{row['residual']:.3f}" if row["residual"] is not None else "–",
            f"{row['seconds']:.1f}",
        ]
        for name, row in rows.items()
    ]
    return _below(f"{stored.provenance.summary}.", marked.table(head, cells))


def _below(how: str, lines: list[str]) -> str:
    """The text of a block: how a table came about, and the table."""
    return "\n".join(["", "", how, "", *lines, "", ""])


def line(stored: Stored) -> str:
    """The result in one sentence, for a cell of another table."""
    row = summarise("all", stored.scores)
    cases = sum(stored.provenance.asked.values())
    parts = [
        f"{row.cases - row.failed} of {cases} folders done",
        f"every point right in {row.every_point[0]} of {row.every_point[1]}",
        f"name and status right for {row.status[0]} of {row.status[1]} effects",
        f"a false finding in {row.alarms[0]} of {row.alarms[1]} folders",
    ]
    if row.residual == row.residual:
        parts.append(f"residual {row.residual:.3f} of the noise (median)")
    return f"{', '.join(parts)}; commit {stored.provenance.commit[:12] or 'not known'}"


def command(stored: Stored) -> str:
    """The command that makes the result again."""
    return f"`{stored.provenance.command}`"


#: Scores of the table of peers that count something of something, and their headings.
_OF_PEERS = {
    "every_point": "every point right",
    "verdict": "verdict",
    "status": "name and status",
    "located": "located",
    "precision": "findings right",
    "alarms": "folders with a false finding",
}
_KINDS: dict[str, Callable[[Stored], str]] = {"table": table, "all": whole, "line": line, "command": command}
#: Tables with columns of their own, by the name of the result.
_OF_A_FORM_OF_THEIR_OWN: dict[str, Callable[[Path], str]] = {CRITERIA: criteria_table.page, PEERS: beside_peers}


def filled(page: str, results: Path) -> str:
    """The page's text with every block made from the stored results under ``results``.

    Raises
    ------
    ResultsError
        A block asks for what there is not.
    """
    return _BLOCK.sub(lambda m: f"{m[1]}{_block(m['name'], m['what'], results)}{m[5]}", page)


def write(root: Path) -> list[Path]:
    """Make the figures of all pages under ``root`` anew; returns the pages that changed.

    Raises
    ------
    ResultsError
        ``root`` is no checkout, or a page asks for what there is not.
    """
    changed = []
    for name in PAGES:
        page = root / name
        if not page.is_file():
            raise ResultsError(f"{page} is not there: give the command in a checkout of this repository.")
        before = page.read_text(encoding="utf-8")
        after = filled(before, root / RESULTS)
        if after != before:
            page.write_text(after, encoding="utf-8")
            changed.append(page)
    return changed


def _block(name: str, what: str, results: Path) -> str:
    if name not in COMMANDS or what not in _KINDS:
        raise ResultsError(f"there is no figure 'proof {name} {what}'.")
    path = results / f"{name}.json"
    if path.exists():
        return _OF_A_FORM_OF_THEIR_OWN[name](path) if name in _OF_A_FORM_OF_THEIR_OWN else _KINDS[what](load(path))
    missing = f"not run with this examination yet (`{COMMANDS[name]} --store {RESULTS.as_posix()}/{name}.json`)"
    return missing if what in ("line", "command") else f"\n\nThis was {missing}.\n\n"
