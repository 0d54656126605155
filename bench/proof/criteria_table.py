"""Every number that decides in the mismatch analysis, at half and at twice its value: what changes in which folders.

Folders are made as for any other examination and analysed once as they are, then with one number of
:mod:`bench.mismatch.criteria` changed at a time, each in a process of its own.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.mismatch import criteria
from bench.processes import over
from bench.proof import make, seal
from bench.proof.analyse import Job, analyser_digest, done_before, prove_case
from bench.proof.marked import table as lines_of
from bench.proof.recompute import recompute
from bench.proof.results import Provenance, ResultsError
from bench.proof.score import score

FORMAT, VERSION = "bench-proof-criteria", "1.0"
FACTORS = {"half": 0.5, "twice": 2.0}
FOLLOWS = {"ERROR_RATE": ("ERROR_RATE_OF_A_CHANNEL",)}
"""numbers that are worked out from another when the module is read"""
FIXED = ("REFERENCE_CELSIUS",)
"""numbers that decide nothing: a definition of the simulation"""
TIME_LIMIT_S = 900.0
_RUN = """import json, sys
from bench.mismatch import criteria
for name, value in json.loads(sys.argv.pop(1)).items():
    setattr(criteria, name, value)
from bench.cli import main
sys.argv[0] = "bench"
main()"""


@dataclass(frozen=True, slots=True)
class Change:
    """One analysis of one folder with a number changed."""

    job: Job
    name: str
    factor: str


def numbers() -> dict[str, float]:
    """The numbers that decide, by name, in the order in which they are written down."""
    return {
        name: value
        for name, value in vars(criteria).items()
        if name.isupper() and isinstance(value, int | float) and name not in FIXED
    }


def changed(name: str, factor: str) -> dict[str, float]:
    """A number at a part of its value, or at a multiple, with those that follow it; a count stays whole."""
    out = {}
    for number in (name, *FOLLOWS.get(name, ())):
        value = numbers()[number] * FACTORS[factor]
        out[number] = max(1, round(value)) if isinstance(numbers()[number], int) else value
    return out


def examined(jobs: Sequence[Job], processes: int, notify: Callable[[str], None]) -> dict[str, Any]:
    """Analyse every folder as it is and with each number changed; what came of it, as JSON-ready values.

    What was done before by the same analyser is not done again.
    """
    for job in jobs:
        prove_case(job)
        notify(f"{job.name} as it is")
    changes = [Change(job, name, factor) for name in numbers() for factor in FACTORS for job in jobs]
    found: dict[tuple[str, str], dict[str, dict[str, Any]]] = {}
    for change, result in zip(changes, over(_analysed, changes, processes), strict=True):
        found.setdefault((change.name, change.factor), {})[change.job.name] = result
        notify(f"{change.name} {change.factor}: {change.job.name}")
    plain = {job.name: _plain(job) for job in jobs}
    rows = []
    for name, value in numbers().items():
        row: dict[str, Any] = {"name": name, "value": value}
        for factor in FACTORS:
            results = found[name, factor]
            row[factor] = {
                "value": changed(name, factor)[name],
                "right": sum(bool(r["right"]) for r in results.values()),
                "otherwise": [case for case, r in results.items() if r["told"] != plain[case]["told"]],
            }
        rows.append(row)
    right = [case for case, r in plain.items() if r["right"]]
    return {"folders": list(plain), "right": right, "rows": rows}


def _plain(job: Job) -> dict[str, Any]:
    outcome = done_before(job)
    assert outcome is not None
    return _result(outcome.truth, outcome.report, outcome.failed, outcome.recomputed)


def _analysed(change: Change) -> dict[str, Any]:
    job = change.job
    truth = seal.read_truth(job.out / seal.TRUTHS / f"{job.name}.json")
    target = job.out / "criteria" / f"{change.name}-{change.factor}" / truth["folder"]
    note = target / "result.json"
    values, analyser = changed(change.name, change.factor), analyser_digest()
    if note.exists():
        before: dict[str, Any] = json.loads(note.read_text(encoding="utf-8"))
        if before["analyser"] == analyser and before["values"] == values:
            return before
    target.mkdir(parents=True, exist_ok=True)
    folder = job.out / make.RECORDINGS / truth["folder"]
    command = [sys.executable, "-c", _RUN, json.dumps(values), "mismatch", str(folder), "--out", str(target)]
    limits = {key: "1" for key in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")}
    failed = ""
    try:
        done = subprocess.run(
            command, env={**os.environ, **limits}, capture_output=True, text=True, timeout=TIME_LIMIT_S, check=False
        )
        if not (target / "report.json").exists():
            failed = (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1]
    except subprocess.TimeoutExpired:
        failed = f"no report within {TIME_LIMIT_S:.0f} s"
    report = None if failed else json.loads((target / "report.json").read_text(encoding="utf-8"))
    recomputed = None if report is None else recompute(truth, report, target / "model.json", folder)
    result = _result(truth, report, failed, recomputed) | {"analyser": analyser, "values": values}
    note.write_text(json.dumps(result), encoding="utf-8")
    return result


def _result(
    truth: Mapping[str, Any], report: Mapping[str, Any] | None, failed: str, recomputed: Mapping[str, Any] | None
) -> dict[str, Any]:
    """Whether every point is right, and what the report tells: effects with channel and status, in a fixed order."""
    findings = [] if report is None else report["findings"]
    findings_of = sorted([f["effect"], f["channel"], f["status"]] for f in findings)
    return {
        "right": score(truth, report, 0.0, failed, recomputed).every_point_right,
        "told": findings_of,
        "failed": failed,
    }


def as_json(found: Mapping[str, Any], how: Mapping[str, Any]) -> dict[str, Any]:
    """The result with how it came about."""
    return {"format": FORMAT, "format_version": VERSION, "provenance": dict(how), **found}


def page(path: Path) -> str:
    """The table of a stored result, as Markdown.

    Raises
    ------
    ResultsError
        The file is no such result.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if (content["format"], content["format_version"]) != (FORMAT, VERSION):
            raise ResultsError(f"{path}: {content['format']} {content['format_version']} is not {FORMAT} {VERSION}.")
        provenance = content["provenance"]
        how = Provenance(**{**provenance, "seeds": tuple(provenance["seeds"])})
        folders, right = content["folders"], content["right"]
        rows = [[f"`{r['name']}`", _number(r["value"]), *_cells(r, len(folders))] for r in content["rows"]]
    except (ValueError, KeyError, TypeError) as error:
        raise ResultsError(f"{path}: is no stored result of bench prove --criteria ({error}).") from error
    without = sum(not r["half"]["otherwise"] and not r["twice"]["otherwise"] for r in content["rows"])
    head = ["number", "value", "half: right", "reported otherwise", "twice: right", "reported otherwise"]
    return "\n".join(
        [
            "",
            "",
            f"{how.summary}. Folders: {', '.join(folders)}. With the values as they are every point is right in "
            f"{len(right)} of {len(folders)}. {without} of {len(rows)} numbers change no report at half or twice.",
            "",
            *lines_of(head, rows),
            "",
            "",
        ]
    )


def _cells(row: Mapping[str, Any], folders: int) -> Iterator[str]:
    for factor in FACTORS:
        cell = row[factor]
        yield f"{cell['right']}/{folders}"
        yield ", ".join(cell["otherwise"]) or "–"


def _number(value: float) -> str:
    return f"{value:g}"


def store(path: Path, content: Mapping[str, Any]) -> None:
    """Write a result, one line a number."""
    head = {key: value for key, value in content.items() if key != "rows"}
    rows = ",\n".join(json.dumps(row, ensure_ascii=False) for row in content["rows"])
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(head, indent=1, ensure_ascii=False)
    path.write_text(f'{text[:-2]},\n "rows": [\n{rows}\n]\n}}\n', encoding="utf-8")
