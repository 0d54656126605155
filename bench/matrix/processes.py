"""What rows of whole processes share: places of their own, a service, and requests to it."""

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

from bench.safety.paths import MACHINE, VARIABLE
from bench.safety.runtime import RUNTIME

PATIENCE_S = 60.0
START_S = 180.0
"""A busy computer takes a minute to begin a program of this size."""
_SLAVES_PRIORITY = 30
COMMAND = (sys.executable, "-c", "from bench.cli import main; main()")
"""Begin of a command line of this program."""


def as_hardware() -> tuple[str, ...]:
    """Return the options of an emulator that waits for no processor, as slaves do not; none where that is refused."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_SLAVES_PRIORITY))
    except PermissionError:
        return ()
    os.sched_setscheduler(0, *before)
    return "--priority", str(_SLAVES_PRIORITY)


@contextmanager
def own_places(folder: Path) -> Iterator[None]:
    """Locks and state below a folder, for this process and those it starts."""
    places = {RUNTIME: str(folder / "locks"), VARIABLE: str(folder / "state"), MACHINE: str(folder / "machine")}
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
def running_service(recordings: Path, *options: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run ``bench serve`` with its recordings in a folder; yield process and address once it answers."""
    port = free_port()
    address = f"http://127.0.0.1:{port}"
    command = [*COMMAND, "serve", "--port", str(port), "--folder", str(recordings), *options]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, text=True)
    try:
        until(lambda: process.poll() is not None or bool(get(address, "health")), START_S, "no service answers")
        yield process, address
    finally:
        with suppress(ProcessLookupError):
            process.terminate()
        try:
            process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def free_port() -> int:
    """Return a port nobody has at the moment."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
        return port


def get(address: str, path: str) -> Any:
    """Return what a service answers; None if it does not."""
    with suppress(OSError), urllib.request.urlopen(f"{address}/api/{path}", timeout=2.0) as answer:
        return json.loads(answer.read() or b"true") or True
    return None


def post(address: str, path: str, **body: Any) -> Any:
    """Ask a service for a change; return its answer."""
    content = json.dumps({"request_id": f"matrix-{time.monotonic_ns()}", **body}).encode()
    headers = {"Content-Type": "application/json", "Origin": address}
    request = urllib.request.Request(f"{address}/api/{path}", content, headers)
    with urllib.request.urlopen(request, timeout=PATIENCE_S) as answer:
        return json.loads(answer.read())


def state(address: str, kind: str) -> dict[str, Any]:
    """Return one message of the state a page starts with."""
    with urllib.request.urlopen(f"{address}/api/state", timeout=PATIENCE_S) as answer:
        return next((message for message in json.loads(answer.read()) if message["type"] == kind), {})


def until(true: Callable[[], bool], patience_s: float, otherwise: str) -> None:
    """Wait until something is true.

    Raises
    ------
    TimeoutError
        If it takes too long.
    """
    deadline = time.monotonic() + patience_s
    while not true():
        if time.monotonic() > deadline:
            raise TimeoutError(otherwise)
        time.sleep(0.05)
