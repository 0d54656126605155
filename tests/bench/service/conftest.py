"""A service for tests: its own folder, its own locks, and a launcher that starts nothing or the real thing."""

from __future__ import annotations

import contextlib
import functools
import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from bench.service.process.ready import Spec
from bench.service.runs.launcher import Launcher
from bench.service.settings import Settings
from bench.service.web.app import create_app

BASE = "http://127.0.0.1:8080"
DEADLINE_S = 60.0


class NoLauncher(Launcher):
    """Starts a process that only waits to be told to end: no bench, no time."""

    def __init__(self) -> None:
        self.jobs: list[dict[str, Any]] = []
        self.processes: list[subprocess.Popen[bytes]] = []

    async def start(self, job: Path, log: Path) -> int:
        self.jobs.append(json.loads(job.read_text("utf-8")))
        # the path of the job stands in its command line, as with a real one
        process = subprocess.Popen([sys.executable, "-c", "import sys, time; time.sleep(60)", str(job)])
        self.processes.append(process)
        return process.pid

    def stand_ready(self, spec: Spec) -> None:
        """Nothing stands ready here: runs of these tests touch no bench."""

    def has_started(self, pid: int) -> bool:
        return any(process.pid == pid for process in self.processes)

    def exit_code(self, pid: int) -> int | None:
        return next((process.poll() for process in self.processes if process.pid == pid), None)

    def close(self) -> None:
        """Runs go on when the service ends, as with the real one."""

    def end_all(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()


@functools.cache
def description() -> dict[str, Any]:
    """The OpenAPI description, put together once for all applications of these tests: the routes are the same."""
    return create_app(Settings(folder=Path("never-made")), NoLauncher()).openapi()


def made_app(settings: Settings, launcher: Launcher) -> FastAPI:
    """Return the application; half of what beginning one takes is its description, which it gets here."""
    app = create_app(settings, launcher)
    app.openapi = description  # type: ignore[method-assign]
    return app


@dataclass
class Client:
    """A service and a client of it, with the request ids and the lease of one operator."""

    http: TestClient
    launcher: NoLauncher
    secret: str = ""
    number: int = 0

    def get(self, path: str, **more: Any) -> Any:
        answer = self.http.get(f"/api/{path}", **more)
        assert answer.status_code == 200, answer.text
        return answer.json()

    def ask(self, path: str, status: int = 200, **body: Any) -> Any:
        """POST with a request id of its own."""
        self.number += 1
        answer = self.http.post(f"/api/{path}", json={"request_id": f"request-{self.number:04d}-{id(self):x}", **body})
        assert answer.status_code == status, answer.text
        return answer.json()

    def take(self, name: str = "Ann", **more: str) -> str:
        self.secret = self.ask("controls/take", name=name, **more)["secret"]
        return self.secret

    def state(self, kind: str) -> dict[str, Any]:
        return next((message for message in self.get("state") if message["type"] == kind), {})

    def until(self, what: Any) -> None:
        deadline = time.monotonic() + DEADLINE_S
        while not what():
            assert time.monotonic() < deadline, "it did not happen in time"
            time.sleep(0.02)


@pytest.fixture(autouse=True)
def own_locks(tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    # not below tmp_path, which has the name of the test: the path of a socket may have 107 bytes
    monkeypatch.setenv("BENCH_RUNTIME", str(tmp_path_factory.mktemp("locks")))
    monkeypatch.setenv("BENCH_STATE", str(tmp_path / "state"))
    monkeypatch.setenv("BENCH_MACHINE", str(tmp_path / "machine"))


@pytest.fixture
def client(tmp_path: Path) -> Iterator[Client]:
    """A service whose runs are processes that wait."""
    launcher = NoLauncher()
    with TestClient(made_app(Settings(folder=tmp_path / "recordings"), launcher), base_url=BASE) as http:
        yield Client(http, launcher)
    launcher.end_all()


@contextlib.contextmanager
def served(folder: Path, *options: str) -> Iterator[str]:
    """``bench serve`` as a process; gives its address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-c", "from bench.cli import main; main()", "serve", "--port", str(port)]
    process = subprocess.Popen(
        [*command, "--folder", str(folder), *options], stdout=subprocess.PIPE, text=True, env={**os.environ}
    )
    try:
        address = f"http://127.0.0.1:{port}"
        deadline = time.monotonic() + DEADLINE_S
        while True:
            assert process.poll() is None, "bench serve ended"
            assert time.monotonic() < deadline, "bench serve does not answer"
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=2):
                break
            time.sleep(0.1)
        yield address
    finally:
        _end_runs(folder / ".service" / "runs.json")
        process.terminate()
        process.wait(30)
        if process.stdout is not None:
            process.stdout.close()


def _end_runs(path: Path) -> None:
    """Runs go on when their service ends; those of a test end with it."""
    for run in json.loads(path.read_text("utf-8")) if path.exists() else ():
        if run["pid"] is not None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(run["pid"], signal.SIGTERM)
