"""Run the analyser on one sealed folder, as a user would, in a process of its own."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bench
from bench.proof import make

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
        threads: threads the analysis may use.
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


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a job: the sealed truth, the report (None where the analysis failed), and how long it took."""

    truth: dict[str, Any]
    report: dict[str, Any] | None
    seconds: float
    failed: str = ""


def draw_case(examiner: Any, job: Job) -> Any:
    """The case of a job."""
    count = None if not job.name.startswith("null-") else int(job.name.rsplit("-", 1)[1]) + 1
    case = next(c for c in examiner.cases(job.group, job.seed, count, job.held_back) if c.name == job.name)
    if job.strength is not None:
        case = examiner.with_strength(case, job.strength, job.label)
    return case


def prove_case(job: Job) -> Outcome:
    """Make the case where it is missing, run ``bench mismatch`` on its recordings, read the report."""
    name = job.label or job.name
    done = _cached(job, name)
    if done is not None:
        return done
    examiner = make.load_examiner()
    truth_path = job.out / make.TRUTHS / f"{name}.json"
    if not (job.out / make.RECORDINGS / name).is_dir():
        truth_path.unlink(missing_ok=True)
    truth = make.read_truth(make.make_case(examiner, draw_case(examiner, job), job.out))
    target = job.out / REPORTS / name
    shutil.rmtree(target, ignore_errors=True)
    begin = time.perf_counter()
    failed = _run(job, name, target)
    seconds = time.perf_counter() - begin
    report = _read(target / "report.json") if not failed else None
    (target).mkdir(parents=True, exist_ok=True)
    note = {"seal": make.seal_of(truth_path), "analyser": analyser_digest(), "seconds": seconds, "failed": failed}
    (target / "proof.json").write_text(json.dumps(note))
    if not job.keep:
        shutil.rmtree(job.out / make.RECORDINGS / name, ignore_errors=True)
    return Outcome(truth, report, seconds, failed)


def analyser_digest() -> str:
    """SHA-256 over the analyser's sources: a report of another analyser is not reused."""
    digest = hashlib.sha256()
    root = Path(bench.__file__).parent
    for package in _ANALYSER_PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            digest.update(path.relative_to(root).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _cached(job: Job, name: str) -> Outcome | None:
    note_path = job.out / REPORTS / name / "proof.json"
    truth_path = job.out / make.TRUTHS / f"{name}.json"
    if not note_path.exists() or not truth_path.exists():
        return None
    note = json.loads(note_path.read_text())
    if note["analyser"] != analyser_digest() or note["seal"] != make.seal_of(truth_path):
        return None
    report = _read(note_path.parent / "report.json") if not note["failed"] else None
    return Outcome(make.read_truth(truth_path), report, note["seconds"], note["failed"])


def _run(job: Job, name: str, target: Path) -> str:
    """Run the analysis; returns why it failed, empty where it did not."""
    command = [sys.executable, "-c", _RUN, "mismatch", str(job.out / make.RECORDINGS / name), "--out", str(target)]
    simulation = make.simulation_for(job.out, name)
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
