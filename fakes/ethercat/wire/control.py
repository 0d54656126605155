"""Orders to a running emulator: one line in, one JSON line out, over a Unix socket.

``fault NAME[:SLAVE][=VALUE][@SECONDS]``, ``clear NAME[:SLAVE]``, ``status``, ``stop``. The frame loop carries an order
out between two frames.
"""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

Order: TypeAlias = Callable[[str, str], dict[str, Any]]
"""Takes verb and argument, returns the answer; ValueError becomes ``{"error": sentence}``."""

TIMEOUT_S = 10.0


class ControlServer:
    """Listens on a Unix socket; each connection is served in turn by one thread."""

    def __init__(self, path: Path, order: Order) -> None:
        self._order = order
        self._path = path
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.bind(str(path))
        self._socket.listen()
        self._thread = threading.Thread(target=self._serve, name="emulator control", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop listening."""
        self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._socket.close()
        self._path.unlink(missing_ok=True)

    def _serve(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:  # closed: the way to end this thread
                return
            with connection, connection.makefile("rw", encoding="utf-8") as lines:
                for line in lines:
                    verb, _, argument = line.strip().partition(" ")
                    try:
                        answer = self._order(verb, argument)
                    except ValueError as error:
                        answer = {"error": str(error)}
                    lines.write(json.dumps(answer) + "\n")
                    lines.flush()


class ControlClient:
    """The other end, for tests and scripts."""

    def __init__(self, path: Path) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(TIMEOUT_S)
        self._socket.connect(str(path))
        self._lines = self._socket.makefile("rw", encoding="utf-8")

    def order(self, line: str) -> dict[str, Any]:
        """Send an order and return its answer; raises ValueError where it was refused."""
        self._lines.write(line + "\n")
        self._lines.flush()
        answer: dict[str, Any] = json.loads(self._lines.readline())
        if "error" in answer:
            raise ValueError(answer["error"])
        return answer

    def close(self) -> None:
        """Close the connection."""
        self._lines.close()
        self._socket.close()
