"""One case through the bench: draw a plant, run a campaign on it, seal the truth, analyse the recordings alone.

While the analysis runs, the truth is in this process' memory only: the disk holds its hash, the folder a random name,
and the analyser's environment what a program needs to start and nothing else.
"""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.errors import ProofError
from bench.proof import make, seal
from bench.proof.seal import load_sealed
from bench.proof.through.loop import closed
from bench.proof.through.run import AGAIN, CAMPAIGN, plant_named, run_on
from bench.proof.through.samples import samples_of

GROUP = "through"
_KEPT = ("PATH", "HOME", "LANG", "LC_ALL", "TMPDIR", "VIRTUAL_ENV", "PYTHONPATH", "NUMBA_CACHE_DIR", "MPLCONFIGDIR")
_RUN = "import sys; from bench.cli import main; sys.argv[0] = 'bench'; main()"
_TWIN_SEED = 99
_DRAWS = 5
_SEEDS = 100_000
"""seeds of a campaign's noise"""


def plant_seed(seed: int, name: str, draw: int = 0) -> int:
    """Seed of the plant of a case, of its ``draw``-th draw: nothing that is seen tells it."""
    number = int(name.rsplit("-", 1)[1])
    return int(np.random.default_rng([seed, 15, number, *([draw] if draw else [])]).integers(2**31))


def noise(out: Path, campaign: Path = CAMPAIGN) -> dict[str, dict[str, float]]:
    """Recording → channel → noise of a campaign on a bench that conceals nothing; made once for all cases of ``out``.

    Raises
    ------
    ProofError
        The campaign did not come to its end.
    """
    path = out / f"twin-{campaign.stem}.json"
    if not path.exists():
        examiner = load_sealed()
        with tempfile.TemporaryDirectory() as folder:
            run_on(plant_named("conceal=0&kinds=&weak=0"), Path(folder) / "twin", _TWIN_SEED, campaign)
            found = examiner.noise_of(samples_of(Path(folder) / "twin", examiner.EVERY))
        out.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(f".{os.getpid()}")
        part.write_text(json.dumps(found), encoding="utf-8")
        part.replace(path)
    content: dict[str, dict[str, float]] = json.loads(path.read_text("utf-8"))
    return content


@dataclass(frozen=True, slots=True)
class Recorded:
    """A case whose campaign has run: its truth and the bytes that were sealed, plant and seed."""

    truth: dict[str, Any]
    content: bytes
    plant: str
    seed: int


def record(out: Path, name: str, seed: int) -> Recorded:
    """Draw the plant of a case, run the campaign on it; the truth, and its sealed bytes.

    Only their hash is written (``truth/NAME.sha256``). A plant that breaks a limit of its own bench is no campaign: it
    is drawn anew, as an operator would mend the bench first.

    Raises
    ------
    ProofError
        None of the draws came to the end of the campaign.
    """
    floor, examiner, alias = noise(out), load_sealed(), secrets.token_hex(6)
    with tempfile.TemporaryDirectory() as secret:
        ledger = Path(secret) / "ledger"
        folder = out / make.RECORDINGS / alias
        for draw in range(_DRAWS):
            plant_number = plant_seed(seed, name, draw)
            plant = plant_named(f"conceal={plant_number}")
            try:
                run_on(f"{plant}&ledger={ledger}", folder, plant_number % _SEEDS)
                break
            except ProofError:
                if draw == _DRAWS - 1:
                    raise
        samples = samples_of(folder, examiner.EVERY)
        truth = examiner.truth_of(plant, str(ledger), samples, _of(samples, floor), name, seed, alias)
    content = json.dumps(truth, indent=1, allow_nan=False, default=float).encode()
    path = out / seal.TRUTHS / f"{name}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    path.with_suffix(".sha256").write_text(f"{hashlib.sha256(content).hexdigest()}  {path.name}\n")
    return Recorded(json.loads(content), content, plant, plant_number % _SEEDS)


def _of(samples: list[dict[str, Any]], floor: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """The twin's noise of each recording; of one that the twin has not (a further heating), that of all its own."""
    channels = {channel for row in floor.values() for channel in row}
    pooled = {
        channel: float(np.sqrt(np.mean([row[channel] ** 2 for row in floor.values() if channel in row])))
        for channel in channels
    }
    return {one["id"]: dict(floor.get(one["id"], pooled)) for one in samples}


def analyse(folder: Path, target: Path, simulation: Path | None = None, limit_s: float = 1800.0) -> str:
    """Run ``bench mismatch`` on recordings; why it failed, empty where it did not.

    It starts in the folder of its report, with an environment that says nothing of the case.
    """
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    command = [sys.executable, "-c", _RUN, "mismatch", str(folder.absolute()), "--out", str(target.absolute())]
    if simulation is not None:
        command += ["--simulation", str(simulation.absolute())]
    try:
        done = subprocess.run(
            command, env=environment(), cwd=target, capture_output=True, text=True, timeout=limit_s, check=False
        )
    except subprocess.TimeoutExpired:
        return f"no report within {limit_s:.0f} s"
    if not (target / "report.json").exists():
        last = (done.stderr.strip() or done.stdout.strip() or "no output").splitlines()[-1]
        return f"exit code {done.returncode}: {last}"
    return ""


def environment() -> dict[str, str]:
    """The environment an analysis gets."""
    kept = {key: value for key, value in os.environ.items() if key in _KEPT}
    return kept | dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


def again(recorded: Recorded, model: Path, out: Path) -> dict[str, Any]:
    """What of the model found on a case holds on another campaign on its plant (:func:`closed`)."""

    def check(folder: Path, given: Path) -> str:
        target = folder.with_name("report")
        why = analyse(folder, target, given)
        return why or str(json.loads((target / "report.json").read_text("utf-8"))["verdict"])

    return closed(recorded.plant, recorded.seed, model, noise(out, AGAIN), check)


def timed(folder: Path, target: Path) -> tuple[str, float]:
    """Analyse; why it failed, and seconds by the clock."""
    begin = time.perf_counter()
    failed = analyse(folder, target)
    return failed, time.perf_counter() - begin
