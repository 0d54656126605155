"""Run the analyser on one sealed folder, as a user would, in a process of its own."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bench.proof import make, seal
from bench.proof.recompute import recompute
from bench.proof.through import case as through
from bench.version import PACKAGE

REPORTS = "reports"
_ANALYSER_PACKAGES = ("mismatch", "simulation", "recording", "identification")
_RUN = "import sys; from bench.cli import main; sys.argv[0] = 'bench'; main()"


@dataclass(frozen=True, slots=True)
class Job:
    """One case to prove, picklable: workers draw the case anew from these.

    Attributes:
        name: the case's name within its group; strength: overrides the case's own, for a severity sweep.
        out: folder that holds recordings, truth and reports.
        keep: leave the recordings on the disk when the report is there.
        threads: threads the analysis may use. clutter: the gearbox has weak orders.
        again: of a case through the bench, ask another campaign on the same plant whether the model holds.
    """

    group: str
    name: str
    seed: int
    held_back: bool
    out: Path
    strength: float | None = None
    label: str = ""
    keep: bool = False
    threads: int = 1
    time_limit_s: float = 900.0
    clutter: bool = False
    again: bool = False


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a job.

    Attributes:
        truth: sealed before. report: None where the analysis failed. seconds: how long it took, by the clock.
        recomputed: what the examiner works out from ``model.json`` and the recordings, before these are thrown away.
    """

    truth: dict[str, Any]
    report: dict[str, Any] | None
    seconds: float
    failed: str = ""
    recomputed: dict[str, Any] | None = None


def draw_case(examiner: Any, job: Job) -> Any:
    """The case of a job."""
    count = None if not job.name.startswith("null") else int(job.name.rsplit("-", 1)[1]) + 1
    case = next(c for c in examiner.cases(job.group, job.seed, count, job.held_back, job.clutter) if c.name == job.name)
    if job.strength is not None:
        case = examiner.with_strength(case, job.strength, job.label)
    return case


def prove_case(job: Job) -> Outcome:
    """Make the case where it is missing, run ``bench mismatch`` on its recordings, read the report."""
    name = job.label or job.name
    done = done_before(job)
    if done is not None:
        return done
    if job.group == through.GROUP:
        return _through(job)
    examiner = make.load_examiner()
    case = draw_case(examiner, job)
    truth_path = job.out / seal.TRUTHS / f"{name}.json"
    recordings = job.out / make.RECORDINGS / case.alias
    if not recordings.is_dir():
        truth_path.unlink(missing_ok=True)
    truth = seal.read_truth(make.make_case(examiner, case, job.out))
    target = job.out / REPORTS / case.alias
    shutil.rmtree(target, ignore_errors=True)
    begin = time.perf_counter()
    failed = _run(job, case.alias, target)
    seconds = time.perf_counter() - begin
    return _finished_outcome(job, truth, truth_path, Outcome(truth, None, seconds, failed))


def _through(job: Job) -> Outcome:
    """Prove a case whose physics is in the plant: campaign, seal, analysis; then the truth is written."""
    recorded = through.record(job.out, job.name, job.seed)
    truth = recorded.truth
    recordings = job.out / make.RECORDINGS / truth["folder"]
    target = job.out / REPORTS / truth["folder"]
    failed, seconds = through.timed(recordings, target)
    again = through.again(recorded, target / "model.json", job.out) if job.again and not failed else None
    truth_path = job.out / seal.TRUTHS / f"{job.name}.json"
    truth_path.write_bytes(recorded.content)
    return _finished_outcome(job, truth, truth_path, Outcome(truth, None, seconds, failed), again)


def _finished_outcome(
    job: Job, truth: dict[str, Any], truth_path: Path, ran: Outcome, again: dict[str, Any] | None = None
) -> Outcome:
    """Read the report of an analysis that ``ran``, recompute what the examiner does, and note both.

    ``again``: what of its model holds on new data, where that was asked.
    """
    recordings, target = (job.out / folder / truth["folder"] for folder in (make.RECORDINGS, REPORTS))
    report = _read(target / "report.json") if not ran.failed else None
    target.mkdir(parents=True, exist_ok=True)
    recomputed = None if report is None else recompute(truth, report, target / "model.json", recordings)
    if recomputed is not None and again is not None:
        recomputed["again"] = again
    note = {
        "seal": seal.seal_of(truth_path),
        "analyser": analyser_digest(),
        "seconds": ran.seconds,
        "failed": ran.failed,
        "own": recomputed,
    }
    (target / "proof.json").write_text(json.dumps(note))
    if not job.keep:
        shutil.rmtree(recordings, ignore_errors=True)
    return replace(ran, report=report, recomputed=recomputed)


def analyser_digest() -> str:
    """SHA-256 over the analyser's sources: a report of another analyser is not reused."""
    digest = hashlib.sha256()
    root = PACKAGE
    for package in _ANALYSER_PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            digest.update(path.relative_to(root).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def done_before(job: Job) -> Outcome | None:
    """What came of a job the last time, None where it was not done by this analyser on this truth."""
    name = job.label or job.name
    truth_path = job.out / seal.TRUTHS / f"{name}.json"
    if not truth_path.exists():
        return None
    truth = seal.read_truth(truth_path)
    note_path = job.out / REPORTS / truth.get("folder", name) / "proof.json"
    if not note_path.exists():
        return None
    note = json.loads(note_path.read_text())
    if note["analyser"] != analyser_digest() or note["seal"] != seal.seal_of(truth_path):
        return None
    if job.again and not note["failed"] and "again" not in note["own"]:
        return None
    report = _read(note_path.parent / "report.json") if not note["failed"] else None
    return Outcome(truth, report, note["seconds"], note["failed"], note["own"])


def _run(job: Job, folder: str, target: Path) -> str:
    """Run the analysis of the folder of that name; returns why it failed, empty where it did not."""
    command = [sys.executable, "-c", _RUN, "mismatch", str(job.out / make.RECORDINGS / folder), "--out", str(target)]
    simulation = make.simulation_for(job.out, folder)
    if simulation is not None:
        command += ["--simulation", str(simulation)]
    limits = {key: str(job.threads) for key in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")}
    try:
        done = subprocess.run(
            command, env={**os.environ, **limits}, capture_output=True, text=True, timeout=job.time_limit_s, check=False
        )
    except subprocess.TimeoutExpired:
        return f"no report within {job.time_limit_s:.0f} s"
    if not (target / "report.json").exists():
        last = (done.stderr.strip() or done.stdout.strip() or "no output").splitlines()[-1]
        return f"exit code {done.returncode}: {last}"
    return ""


def _read(path: Path) -> dict[str, Any]:
    report: dict[str, Any] = json.loads(path.read_text())
    return report
