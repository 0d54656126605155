"""Let the peers sit the exam and put them into one table with us."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np

from bench.errors import ProofError
from bench.proof import make, seal
from bench.proof.analyse import Job
from bench.proof.peers.candidates import Problem, problems
from bench.proof.peers.location import location_of
from bench.proof.peers.methods import METHODS, Method, held_out, pick
from bench.proof.peers.rows import read_rows
from bench.proof.score import CaseScore, score
from bench.proof.statistics import summarise
from bench.proof.table import summary_rows

PEER_REPORTS = "peers"
_NEEDED = ("sklearn", "pysindy", "sysidentpy", "gplearn", "pyoperon")


@dataclass(frozen=True, slots=True)
class Compared:
    """Scores of each peer over the same folders."""

    scores: dict[str, list[CaseScore]]

    def markdown(self) -> str:
        """One row a peer, over all folders and by set."""
        lines = ["## Peers on the same residuals", ""]
        for name, scores in self.scores.items():
            lines += [f"### {name}", "", *summary_rows(scores), ""]
        return "\n".join(lines) + "\n"

    def to_dict(self) -> dict[str, Any]:
        """Summary of each peer."""
        return {name: asdict(summarise("all", scores)) for name, scores in self.scores.items()}


def compare_peers(jobs: Sequence[Job], methods: dict[str, Method] | None = None) -> Compared:
    """Run every peer on the recordings of the jobs (made again where they are gone).

    Raises
    ------
    ProofError
        The optional dependencies are missing.
    """
    missing = [name for name in _NEEDED if find_spec(name) is None]
    if missing and methods is None:
        raise ProofError(f"--peers needs {', '.join(missing)}: install the optional dependencies 'peers'.")
    chosen = methods or METHODS
    scores: dict[str, list[CaseScore]] = {name: [] for name in chosen}
    for job in jobs:
        truth_path = job.out / seal.TRUTHS / f"{job.label or job.name}.json"
        truth = seal.read_truth(truth_path)
        for name, (report, seconds) in _reports(job, truth["folder"], chosen, seal.seal_of(truth_path)).items():
            scores[name].append(score(truth, report, seconds))
    return Compared(scores)


def _reports(
    job: Job, folder: str, methods: dict[str, Method], seal: str | None
) -> dict[str, tuple[dict[str, Any], float]]:
    """Report and seconds of every peer on one folder; taken from the disk where the same folder was done before."""
    path = job.out / PEER_REPORTS / f"{folder}.json"
    known = json.loads(path.read_text()) if path.exists() else {}
    if known.get("seal") != seal:
        known = {"seal": seal, "reports": {}}
    missing = [name for name in methods if name not in known["reports"]]
    if missing:
        begin = time.perf_counter()
        posed = list(problems(read_rows(job.out / make.RECORDINGS / folder)))
        shared = time.perf_counter() - begin
        for name in missing:
            begin = time.perf_counter()
            report = peer_report(posed, methods[name])
            known["reports"][name] = report, shared + time.perf_counter() - begin
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(known))
    return {name: tuple(known["reports"][name]) for name in methods}


def peer_report(posed: Iterable[Problem], method: Method) -> dict[str, Any]:
    """What a peer finds, as a mismatch report: one finding a name, confidence 0.9 as it gives none."""
    findings: list[dict[str, Any]] = []
    channels = []
    for problem in posed:
        picked = pick(method, problem)
        channels.append({"channel": problem.channel, "held_out_rmse_after": held_out(problem, picked)})
        for effect in sorted({problem.effects[i] for i in picked}):
            orders = sorted(
                {problem.orders[i] for i in picked if problem.effects[i] == effect and problem.orders[i] > 0}
            )
            findings.append(_finding(effect, problem.channel, orders, location_of(problem, picked, effect)))
    return {"verdict": "mismatch" if findings else "match", "findings": _once(findings), "channels": channels}


def _finding(effect: str, channel: str, orders: list[float], location: dict[str, Any]) -> dict[str, Any]:
    return {
        "effect": effect,
        "status": "named",
        "confidence": 0.9,
        "channel": channel,
        "location": {"orders": [k for k in orders if np.isfinite(k)], "angle_windows": [], **location},
        "parameters": [],
        "alternatives": [],
    }


def _once(findings: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One finding an effect, in the first channel it shows in."""
    seen: dict[str, dict[str, Any]] = {}
    for finding in findings:
        seen.setdefault(finding["effect"], finding)
    return list(seen.values())
