"""The launcher: keeps the privileges a bus needs, starts run processes when asked to, and does nothing else.

It is started before the web process gives its own privileges away. Lines of JSON on its input:
``{"job": path, "log": path}``, and ``{"ready": spec}`` for a process that stands ready for the next job; on its output:
``{"started": pid, "job": path}`` or ``{"refused": why, "job": path}``, and ``{"exited": pid, "code": code}``.
It starts two programs only, :mod:`bench.service.process.main` and :mod:`bench.service.process.ready`, each in a session
of its own: runs go on when it ends, and one that stands ready ends with it.
"""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

from bench.service.process.ready import Spec
from bench.service.runs.standby import Standby

Child = subprocess.Popen[bytes]


def serve(orders: IO[str], send: Callable[[dict[str, Any]], None]) -> None:
    """Start what is ordered until the orders end."""
    standby = Standby()

    def follow(child: Child) -> None:
        threading.Thread(target=lambda: send({"exited": child.pid, "code": child.wait()}), daemon=True).start()

    for line in orders:
        order = json.loads(line)
        if "ready" in order:
            child = standby.begin(order["ready"])
            if child is not None:
                follow(child)
            continue
        try:
            child = standby.take(order["job"], order["log"])
            if child is None:
                child = _start(order["job"], order["log"])
                follow(child)
        except OSError as error:
            send({"refused": str(error), "job": order["job"]})
            continue
        send({"started": child.pid, "job": order["job"]})


def _start(job: str, log_path: str) -> Child:
    with Path(log_path).open("ab") as log:
        return subprocess.Popen(
            [sys.executable, "-m", "bench.service.process.main", job],
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )


def main() -> None:
    """Serve the parent's orders."""
    lock = threading.Lock()

    def send(message: dict[str, Any]) -> None:
        with lock:
            sys.stdout.write(json.dumps(message) + "\n")
            sys.stdout.flush()

    serve(sys.stdin, send)


class Launcher:
    """The web process's end: starts the launcher, passes orders on, knows which runs have exited."""

    def __init__(self) -> None:
        environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "bench.service.runs.launcher"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
            start_new_session=True,
        )
        self._changed, self._ordering = threading.Condition(), threading.Lock()
        self._started: dict[str, int | str] = {}
        """Process id, or why it was not started, by job."""
        self._exited: dict[int, int] = {}
        self._own: set[int] = set()
        threading.Thread(target=self._read, name="launcher", daemon=True).start()

    async def start(self, job: Path, log: Path) -> int:
        """Start a run and return its process id.

        Raises
        ------
        OSError
            If the launcher is gone or cannot start it.
        """
        return await asyncio.to_thread(self._start, job, log)

    def stand_ready(self, spec: Spec) -> None:
        """Have a process stand ready for the next run; nothing if one does. A launcher that is gone says so itself."""
        stdin = self._process.stdin
        if stdin is not None and self._process.poll() is None:
            self._order({"ready": spec.as_dict()})

    def has_started(self, pid: int) -> bool:
        """Whether a run is this launcher's own, so that its exit will be heard of."""
        return pid in self._own

    def exit_code(self, pid: int) -> int | None:
        """Exit code of a run that has ended, None if it runs (or was started by an earlier service)."""
        return self._exited.get(pid)

    def close(self) -> None:
        """End the launcher; runs go on."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._process.wait(10)

    def _start(self, job: Path, log: Path) -> int:
        stdin = self._process.stdin
        if stdin is None or self._process.poll() is not None:
            raise OSError("the launcher of runs is gone; restart the service")
        self._order({"job": str(job), "log": str(log)})
        with self._changed:
            if not self._changed.wait_for(lambda: str(job) in self._started, 30):
                raise OSError("the launcher of runs did not answer within 30 s; restart the service")
            answer = self._started.pop(str(job))
        if isinstance(answer, str):
            raise OSError(answer)
        return answer

    def _order(self, order: dict[str, Any]) -> None:
        stdin = self._process.stdin
        assert stdin is not None
        with self._ordering:
            stdin.write(json.dumps(order) + "\n")
            stdin.flush()

    def _read(self) -> None:
        for line in self._process.stdout or ():
            message = json.loads(line)
            with self._changed:
                if "started" in message:
                    self._started[message["job"]] = message["started"]
                    self._own.add(message["started"])
                elif "refused" in message:
                    self._started[message["job"]] = message["refused"]
                else:
                    self._exited[message["exited"]] = message["code"]
                self._changed.notify_all()


if __name__ == "__main__":
    main()
