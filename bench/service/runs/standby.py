"""The one process that stands ready for the next run, as the launcher sees it; imports nothing heavy."""

from __future__ import annotations

import json
import secrets
import subprocess
import sys
from pathlib import Path
from typing import Any

from bench.safety.runtime import runtime_folder

LINKS = "ready-"
"""Beginning of the names of links that lead from a process that stood ready to its job."""


class Standby:
    """Begins such a process and hands it a job; used by one thread only."""

    def __init__(self) -> None:
        self._child: subprocess.Popen[bytes] | None = None
        self._link = Path()

    def begin(self, spec: dict[str, Any]) -> subprocess.Popen[bytes] | None:
        """Begin one and return it; None if one stands ready, or none can be begun: a run then starts without it."""
        if self._child is not None and self._child.poll() is None:
            return None
        try:
            self._link = runtime_folder() / f"{LINKS}{secrets.token_hex(8)}"
            self._child = subprocess.Popen(
                [sys.executable, "-m", "bench.service.process.ready", str(self._link), json.dumps(spec)],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        except OSError:
            self._child = None
        return self._child

    def take(self, job: str, log: str) -> subprocess.Popen[bytes] | None:
        """Hand the job to the process that stands ready and return it; None where there is none.

        Raises
        ------
        OSError
            If the log cannot be written: no run begins without one.
        """
        child, self._child = self._child, None
        if child is None or child.stdin is None or child.poll() is not None:
            return None
        with Path(log).open("ab"):
            pass
        self._link.symlink_to(Path(job).absolute())
        try:
            with child.stdin as orders:
                orders.write(json.dumps({"job": job, "log": log}).encode() + b"\n")
        except BrokenPipeError:
            self._link.unlink()
            return None
        return child


def leads_to(argument: bytes, job: bytes) -> bool:
    """Whether an argument of a command line is the link of a process that stood ready, and leads to a job."""
    path = Path(argument.decode("utf-8", "surrogateescape"))
    if not path.name.startswith(LINKS):
        return False
    try:
        return str(path.readlink()).encode() == job
    except OSError:
        return False
