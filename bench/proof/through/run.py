"""One campaign on an emulated bench, by the process that runs the service's campaigns, in fast time."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from bench.configuration import load_bench
from bench.errors import ProofError

CAMPAIGN = Path(__file__).with_name("campaign.toml")
AGAIN = Path(__file__).with_name("again.toml")
"""another campaign on the same plant: other loads, speeds and temperatures"""
BENCH = "rh380n"
_LONGEST_S = 3600.0


def plant_named(behind: str, bench: str = BENCH) -> str:
    """The name of the bench's plant with what it conceals.

    Raises
    ------
    ProofError
        The bench is not emulated.
    """
    base = load_bench(bench).configuration.bus.plant
    if base is None:
        raise ProofError(f"{bench} has no emulated plant.")
    return f"{base}?{behind}" if behind else base


def run_on(plant: str, folder: Path, seed: int, campaign: Path = CAMPAIGN, bench: str = BENCH) -> None:
    """Run a campaign on a plant into ``folder``, with the service's drivers, safety and recorder.

    The job file, which says what is concealed, lies in a folder of its own and is gone afterwards.

    Raises
    ------
    ProofError
        The campaign did not come to its end.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as secret:
        folder_of_run = Path(secret)
        job = {
            "run": folder.name,
            "campaign": str(campaign),
            "bench": bench,
            "folder": str(folder.absolute()),
            "socket": str(folder_of_run / "socket"),
            "outcome": str(folder_of_run / "outcome.json"),
            "seed": seed,
            "plant": plant,
        }
        path = folder_of_run / "job.json"
        path.write_text(json.dumps(job), encoding="utf-8")
        command = [sys.executable, "-m", "bench.service.process.main", str(path)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=_LONGEST_S, check=False)
        except subprocess.TimeoutExpired as error:
            raise ProofError(f"the campaign into {folder.name} did not end within {_LONGEST_S:.0f} s.") from error
        outcome = folder_of_run / "outcome.json"
        end = json.loads(outcome.read_text("utf-8")) if outcome.exists() else {}
        if end.get("kind") not in ("finished", "failed_points"):
            why = end.get("text") or done.stderr.strip() or f"exit code {done.returncode}"
            raise ProofError(f"the campaign into {folder.name} ended early: {why}")
