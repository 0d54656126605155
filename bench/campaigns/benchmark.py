"""Measure a whole campaign in a process of its own: speed, memory, disk; and whether it survives being killed."""

from __future__ import annotations

import json
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from bench.campaigns import load_campaign, make_plan
from bench.configuration import load_bench
from bench.errors import BenchError, ConfigurationError
from bench.recording import RecordingFolder
from bench.recording.validation import validate

_COMMAND = (sys.executable, "-c", "from bench.cli import main; main()")
_POLL_S = 0.02


@dataclass(frozen=True, slots=True)
class CampaignFigures:
    """What one undisturbed campaign took."""

    campaign: str
    recordings: int
    valid: int
    failed: int
    cycles: int
    bench_time_s: float
    wall_s: float
    cpu_s: float
    peak_memory_bytes: int
    disk_bytes: int

    @property
    def times_real_time(self) -> float:
        """Bench time by wall time, the start of the program included."""
        return self.bench_time_s / self.wall_s

    def as_dict(self) -> dict[str, Any]:
        """For ``--json``."""
        return {**asdict(self), "times_real_time": self.times_real_time}


@dataclass(frozen=True, slots=True)
class SurvivalFigures:
    """What a campaign that was killed again and again ended with."""

    campaign: str
    kills: int
    points: int
    points_done: int
    recordings: int
    valid: int
    cut_short: int
    wall_s: float

    @property
    def survived(self) -> bool:
        """Whether every point is done and every file valid."""
        return self.points_done == self.points and self.valid == self.recordings

    def as_dict(self) -> dict[str, Any]:
        """For ``--json``."""
        return {**asdict(self), "survived": self.survived}


def measure_campaign(name: str, bench: str, out: Path | None) -> CampaignFigures:
    """Run a campaign once.

    Raises
    ------
    BenchError
        If the campaign does not come to its end; with what it said.
    """
    with _folder(out) as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        began = time.monotonic()
        done = subprocess.run(_arguments(name, bench, folder), capture_output=True, text=True, check=False)
        wall = time.monotonic() - began
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if not done.stdout.strip():
            raise BenchError(f"the campaign ended with exit code {done.returncode}: {done.stderr.strip()}")
        summary = json.loads(done.stdout)
        files = sorted(folder.glob("*.h5"))
        return CampaignFigures(
            name,
            len(files),
            sum(validate(path).valid for path in files),
            len(summary["failed"]),
            summary["cycles"],
            summary["bench_time_s"],
            wall,
            after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
            after.ru_maxrss * 1024,
            sum(path.stat().st_size for path in folder.iterdir()),
        )


def measure_survival(name: str, bench: str, kills: int, life_s: float, seed: int, out: Path | None) -> SurvivalFigures:
    """Kill a campaign ``kills`` times, each time running it again, then let it end.

    A run lives for a random time (uniform, ``life_s`` on average) from the moment it has begun to record.
    """
    plan = make_plan(load_campaign(name), load_bench(bench).configuration)
    moments = random.Random(seed)
    began, killed = time.monotonic(), 0
    with _folder(out) as folder:
        while killed < kills and _run_and_kill(
            _arguments(name, bench, folder), folder, moments.uniform(0.0, 2.0 * life_s)
        ):
            killed += 1
        final = subprocess.run(_arguments(name, bench, folder), capture_output=True, text=True, check=False)
        if not final.stdout.strip():
            raise BenchError(f"the last run ended with exit code {final.returncode}: {final.stderr.strip()}")
        manifest = json.loads((folder / "campaign.json").read_text("utf-8"))
        planned = {entry["point_id"] for entry in manifest["recordings"] if not entry["kind"].startswith("heating")}
        done = {
            entry["point_id"]
            for entry in manifest["recordings"]
            if entry["status"] == "done" and not entry["kind"].startswith("heating")
        }
        recordings = RecordingFolder.open(folder)
        return SurvivalFigures(
            name,
            killed,
            max(plan.points, len(planned)),
            len(done),
            len(recordings.recordings) + len(recordings.rejected),
            sum(validate(recording.path).valid for recording in recordings.recordings),
            sum(not recording.complete for recording in recordings.recordings),
            time.monotonic() - began,
        )


def _run_and_kill(arguments: list[str], folder: Path, after_s: float) -> bool:
    """Start a run and kill it ``after_s`` after its first row; False if it ended before."""
    old = set(folder.glob("*.part")) if folder.exists() else set()
    process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None and not (folder.exists() and set(folder.glob("*.part")) - old):
        time.sleep(_POLL_S)
    try:
        process.wait(after_s)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        process.wait()
        return True
    return False


def _arguments(name: str, bench: str, folder: Path) -> list[str]:
    return [*_COMMAND, "run", name, "--bench", bench, "--out", str(folder), "--json"]


@contextmanager
def _folder(out: Path | None) -> Iterator[Path]:
    if out is None:
        with tempfile.TemporaryDirectory(prefix="bench-") as folder:
            yield Path(folder)
        return
    if out.exists() and any(out.iterdir()):
        raise ConfigurationError(f"{out} is not empty; a benchmark needs a new folder")
    yield out
