"""An analysis in its process, ``python -m bench.service.analyses.work JOB.json``; it writes progress as JSON lines."""

from __future__ import annotations

import json
import os
import sqlite3
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from bench.errors import BenchError
from bench.whole import write_whole

Kind = Literal["identify", "mismatch", "investigate", "compare"]
_NICE = 10


@dataclass(frozen=True, slots=True)
class Work:
    """What is to be analysed: ``model`` is the simulation a mismatch is sought against, None for the nominal one;
    ``asked`` what an investigation was asked for, or since which recording is compared.
    """

    kind: Kind
    recordings: str
    out: str
    model: str | None = None
    asked: dict[str, Any] = field(default_factory=dict)


def report_progress(what: str, share: float, **more: Any) -> None:
    """Write one line of progress."""
    sys.stdout.write(json.dumps({"what": what, "share": share, **more}, ensure_ascii=False) + "\n")
    sys.stdout.flush()


def identify(work: Work) -> str:
    """Identify, write model.json, report.html and summary.json; return the sentence that sums it up."""
    from bench.identification import Options, identify_folder, to_json, to_simulation
    from bench.identification.report import write_report
    from bench.identification.summary import has_numbers, verdict
    from bench.trend import kept
    from bench.trend.book import since_last

    stamp = kept.stamp_of(Path(work.recordings))
    out = Path(work.out)
    out.mkdir(parents=True, exist_ok=True)
    found = identify_folder(
        Path(work.recordings),
        Options(jobs=1),
        lambda done, total: report_progress(f"reading recording {done} of {total}", 0.9 * done / max(1, total)),
    )
    report_progress("writing the report", 0.92)
    simulation = to_simulation(found, "refined")
    if has_numbers(simulation):
        simulation.save(out / "model.json")
    changed: tuple[str, ...] = ()
    try:
        kept.keep(found, Path(work.recordings), stamp)
        changed = since_last(Path(work.recordings))
    except (OSError, sqlite3.Error) as error:
        report_progress(f"it is not kept for the trend of this gearbox: {error}", 0.93)
    write_report(found, out, changed)
    write_whole(out / "summary.json", json.dumps(to_json(found), indent=1, ensure_ascii=False))
    if found.scores:
        return verdict(found)
    return " ".join(found.sentences) or "Identified; there was nothing to validate it with."


def mismatch(work: Work) -> str:
    """Compare simulation and recordings, write the report; return its verdict in a sentence."""
    from bench.mismatch.run import run

    model = None if work.model is None else Path(work.model)
    return run(Path(work.recordings), Path(work.out), model, report_progress).sentence


def investigate(work: Work) -> str:
    """Look, ask for experiments, look again; return why it ended in a sentence."""
    from bench.service.analyses import experimenting

    asked = experimenting.Investigation(**work.asked)
    return experimenting.investigate(Path(work.recordings), Path(work.out), asked, report_progress, sys.stdin.readline)


def compare(work: Work) -> str:
    """Identify what was recorded before a change and what since, write the report; return what changed."""
    from bench.twin.comparison import before_and_since
    from bench.twin.comparison_page import write_comparison

    found = before_and_since(Path(work.recordings), str(work.asked["since"]), report_progress)
    write_comparison(found, Path(work.out))
    return found.sentence


DOES: dict[Kind, Callable[[Work], str]] = {
    "identify": identify,
    "mismatch": mismatch,
    "investigate": investigate,
    "compare": compare,
}


def main() -> None:
    """Do the work of the file given; the last line says how it ended."""
    os.nice(_NICE)
    work = Work(**json.loads(Path(sys.argv[1]).read_text("utf-8")))
    report_progress("reading", 0.0)
    try:
        text = DOES[work.kind](work)
    except BenchError as error:
        report_progress(str(error), 1.0, ended="failed")
        sys.exit(1)
    report_progress(text, 1.0, ended="done")


if __name__ == "__main__":
    main()
