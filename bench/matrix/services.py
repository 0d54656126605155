"""Rows of the service and of locks: it is killed while its run goes on; a second one, or a second run, is refused."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

from bench.configuration import BenchFile, on_interface
from bench.locks import bus_in_use
from bench.matrix.outcome import Outcome
from bench.matrix.processes import COMMAND, PATIENCE_S, free_port, get, own_places, post, running_service, until
from bench.matrix.rows import Row
from bench.recording.validation import validate


def run_service_row(row: Row, file: BenchFile, folder: Path, seed: int = 0) -> Outcome:
    """Run a row with locks and state of its own."""
    outcome = Outcome(row.name, row.text, row.kind)
    with own_places(folder):
        _RUNS[row.name](row, outcome, file, folder)
    return outcome


def _service_killed(row: Row, outcome: Outcome, file: BenchFile, folder: Path) -> None:
    with running_service(folder / "first") as (process, address):
        secret = post(address, "controls/take", name="matrix")["secret"]
        post(address, "runs", secret=secret, name="matrix", campaign="quick", folder="run")
        until(lambda: any(folder.rglob("*.h5.part")) or any(folder.rglob("*.h5")), PATIENCE_S, "the run does not begin")
        process.kill()
        process.wait()
    # its run is a process of its own: it ends as if nobody had gone
    until(lambda: any(folder.rglob("campaign.json")), PATIENCE_S, "the run did not go on without its service")
    (manifest,) = folder.rglob("campaign.json")
    end = json.loads(manifest.read_text("utf-8"))["end"]
    outcome.reaction = f"its run {end['kind']}"
    outcome.require(end["kind"] == "finished", f"the run ended otherwise: {end}")
    files = sorted(manifest.parent.glob("*.h5"))
    outcome.require(len(files) == 5, f"{len(files)} recordings of 5")
    outcome.require(not list(manifest.parent.glob("*.part")), "a recording was left unfinished")
    for path in files:
        outcome.require(not validate(path).violations, f"{path.name} is not valid")
        outcome.read_back += 1


def _two_services(row: Row, outcome: Outcome, file: BenchFile, folder: Path) -> None:
    with running_service(folder / "first") as (process, address):
        port = str(free_port())
        second = _run_refused_command(outcome, "serve", "--port", port, "--folder", str(folder / "second"))
        outcome.sentence = second.strip().removeprefix("error: ")
        outcome.require(
            row.expected_text in outcome.sentence,
            f"the second was not refused with '{row.expected_text}': {outcome.sentence}",
        )
        outcome.require(process.poll() is None and bool(get(address, "health")), "the first one did not go on")


def _two_runs_on_a_bus(row: Row, outcome: Outcome, file: BenchFile, folder: Path) -> None:
    with bus_in_use(on_interface(file, "matrix0")):
        # the lock is asked for before the interface, which does not even exist here
        said = _run_refused_command(outcome, "commission", "--bus", "matrix0", "--yes")
    outcome.sentence = said.strip().splitlines()[-1].removeprefix("error: ")
    outcome.require(
        row.expected_text in outcome.sentence,
        f"the second was not refused with '{row.expected_text}': {outcome.sentence}",
    )


_RUNS: dict[str, Callable[[Row, Outcome, BenchFile, Path], None]] = {
    "service_killed": _service_killed,
    "two_services": _two_services,
    "two_runs_on_a_bus": _two_runs_on_a_bus,
}


def _run_refused_command(outcome: Outcome, *arguments: str) -> str:
    """Run a command that has to be refused; note whether it was, return what it says."""
    done = subprocess.run(
        [*COMMAND, *arguments],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    outcome.reaction = "refused" if done.returncode else "not refused"
    return done.stderr if done.returncode else f"it was not refused: {done.stdout}"
