"""Rows of the service and of locks: it is killed while its run goes on; a second one, or a second run, is refused."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from bench.configuration import BenchFile, on_interface
from bench.matrix.outcome import Outcome
from bench.matrix.rows import Row
from bench.recording.validation import validate
from bench.safety.places import VARIABLE
from bench.service.registry import RUNTIME, bus_in_use

_PATIENCE_S = 60.0
_COMMAND = [sys.executable, "-c", "from bench.cli import main; main()"]


def run_service_row(row: Row, file: BenchFile, folder: Path, seed: int = 0) -> Outcome:
    """Run a row with locks and state of its own."""
    outcome = Outcome(row.name, row.text, row.kind)
    with _own_places(folder):
        _RUNS[row.name](row, outcome, file, folder)
    return outcome


def _service_killed(row: Row, outcome: Outcome, file: BenchFile, folder: Path) -> None:
    with _service(folder, "first") as (process, address):
        secret = _ask(address, "controls/take", name="matrix")["secret"]
        _ask(address, "runs", secret=secret, name="matrix", campaign="quick", folder="run")
        _until(lambda: any(folder.rglob("*.h5.part")) or any(folder.rglob("*.h5")), "the run does not begin")
        process.kill()
        process.wait()
    # its run is a process of its own: it ends as if nobody had gone
    _until(lambda: any(folder.rglob("campaign.json")), "the run did not go on without its service")
    (manifest,) = folder.rglob("campaign.json")
    end = json.loads(manifest.read_text("utf-8"))["end"]
    outcome.told = f"the run ended: {end['kind']}"
    outcome.require(end["kind"] == "finished", f"the run ended otherwise: {end}")
    files = sorted(manifest.parent.glob("*.h5"))
    outcome.require(len(files) == 5, f"{len(files)} recordings of 5")
    outcome.require(not list(manifest.parent.glob("*.part")), "a recording was left unfinished")
    for path in files:
        outcome.require(not validate(path).violations, f"{path.name} is not valid")
        outcome.read_back += 1


def _two_services(row: Row, outcome: Outcome, file: BenchFile, folder: Path) -> None:
    with _service(folder, "first") as (process, address):
        port = str(_free_port())
        second = _refused("serve", "--port", port, "--folder", str(folder / "second"))
        outcome.told = second.strip().removeprefix("error: ")
        outcome.require(row.told in outcome.told, f"the second was not refused with '{row.told}': {outcome.told}")
        outcome.require(process.poll() is None and bool(_get(address, "health")), "the first one did not go on")


def _two_runs_on_a_bus(row: Row, outcome: Outcome, file: BenchFile, folder: Path) -> None:
    with bus_in_use(on_interface(file, "matrix0")):
        # the lock is asked for before the interface, which does not even exist here
        said = _refused("commission", "--bus", "matrix0", "--yes")
    outcome.told = said.strip().splitlines()[-1].removeprefix("error: ")
    outcome.require(row.told in outcome.told, f"the second was not refused with '{row.told}': {outcome.told}")


_RUNS: dict[str, Callable[[Row, Outcome, BenchFile, Path], None]] = {
    "service_killed": _service_killed,
    "two_services": _two_services,
    "two_runs_on_a_bus": _two_runs_on_a_bus,
}


@contextmanager
def _own_places(folder: Path) -> Iterator[None]:
    """Locks and state below a folder, for this process and those it starts."""
    places = {RUNTIME: str(folder / "locks"), VARIABLE: str(folder / "state")}
    before = {name: os.environ.get(name) for name in places}
    os.environ.update(places)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name)
            else:
                os.environ[name] = value


@contextmanager
def _service(folder: Path, name: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    port = _free_port()
    address = f"http://127.0.0.1:{port}"
    command = [*_COMMAND, "serve", "--port", str(port), "--folder", str(folder / name)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, text=True)
    try:
        _until(lambda: process.poll() is not None or bool(_get(address, "health")), "the service does not answer")
        yield process, address
    finally:
        with suppress(ProcessLookupError):
            process.terminate()
        process.wait(_PATIENCE_S)


def _refused(*arguments: str) -> str:
    """Run a command that has to be refused; return what it says."""
    done = subprocess.run(
        [*_COMMAND, *arguments],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=_PATIENCE_S,
        check=False,
    )
    return done.stderr if done.returncode else f"it was not refused: {done.stdout}"


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
        return port


def _get(address: str, path: str) -> Any:
    with suppress(OSError), urllib.request.urlopen(f"{address}/api/{path}", timeout=2.0) as answer:
        return json.loads(answer.read() or b"true") or True
    return None


def _ask(address: str, path: str, **body: str) -> Any:
    content = json.dumps({"request_id": f"matrix-{time.monotonic_ns()}", **body}).encode()
    headers = {"Content-Type": "application/json", "Origin": address}
    request = urllib.request.Request(f"{address}/api/{path}", content, headers)
    with urllib.request.urlopen(request, timeout=_PATIENCE_S) as answer:
        return json.loads(answer.read())


def _until(true: Callable[[], bool], otherwise: str) -> None:
    deadline = time.monotonic() + _PATIENCE_S
    while not true():
        if time.monotonic() > deadline:
            raise TimeoutError(otherwise)
        time.sleep(0.05)
