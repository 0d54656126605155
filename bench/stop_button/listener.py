"""The listener of a run: two requests of HTTP on 127.0.0.1, the same on a socket that needs no folder.

``POST /stop?by=NAME&pressed_at_ns=N`` presses, ``GET /state`` asks; any page may do both, for all it can do is stop.
The socket's name is abstract (``@gearbench-stop-PID-…``): it works with every disk full, frozen or gone, and listens to
the user of the run and to root. ``stop.json`` in the runtime folder says where the port is; a run that cannot write it
listens all the same.
"""

from __future__ import annotations

import hashlib
import json
import os
import socket
import struct
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from bench.errors import BenchError
from bench.safety.runtime import RUNTIME, runtime_folder
from bench.stop_button.button import StopButton

NAME = "gearbench-stop-"
"""Begin of the abstract socket's name; the tag of the runtime folder and the process id follow."""
FILE = "stop.json"
_REQUEST_S = 1.0
"""A request that is not whole after so long is given up."""
_LONGEST = 4096
_MOST_AT_ONCE = 24
_LONGEST_NAME = 60
_CREDENTIALS = struct.Struct("3i")


class Listener:
    """Listens until it is closed.

    Parameters
    ----------
    button : what is pressed.
    port : on 127.0.0.1; 0 for any that is free.

    Attributes
    ----------
    port : the one listened on; None where there was none to be had.
    """

    def __init__(self, button: StopButton, port: int = 0) -> None:
        self._button = button
        self._sockets: list[socket.socket] = []
        self._threads: list[threading.Thread] = []
        self.port: int | None = None
        unix = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        unix.bind(f"\0{NAME}{runtime_tag()}-{os.getpid()}-{id(self):x}")
        self._listen(unix, _is_own)
        with suppress(OSError):
            web = socket.create_server(("127.0.0.1", port))
            self.port = int(web.getsockname()[1])
            self._listen(web, lambda _: True)

    def close(self) -> None:
        """Stop listening; requests under way are still answered."""
        for listening_socket in self._sockets:
            with suppress(OSError):
                listening_socket.shutdown(socket.SHUT_RDWR)
            listening_socket.close()
        for thread in self._threads:
            # as long as one waits in accept(), the kernel keeps the name, and whoever looks finds a listener
            thread.join(_REQUEST_S)

    def _listen(self, listening_socket: socket.socket, may: Callable[[socket.socket], bool]) -> None:
        listening_socket.listen(64)
        self._sockets.append(listening_socket)
        thread = threading.Thread(target=self._accept, args=(listening_socket, may), name="stop", daemon=True)
        thread.start()
        self._threads.append(thread)

    def _accept(self, listening_socket: socket.socket, may: Callable[[socket.socket], bool]) -> None:
        under_way: deque[socket.socket] = deque()
        while True:
            try:
                connection, _ = listening_socket.accept()
            except OSError:
                return
            while len(under_way) >= _MOST_AT_ONCE:
                # who asks for a stop says so at once; the oldest that has not is not waited for
                _hang_up(under_way.popleft())
            under_way.append(connection)
            threading.Thread(target=self._serve, args=(connection, may), name="stop request", daemon=True).start()

    def _serve(self, connection: socket.socket, may: Callable[[socket.socket], bool]) -> None:
        with connection, suppress(OSError):
            line = _first_line(connection)
            status, body = self._answer(line) if may(connection) else ("403 Forbidden", {"error": "not yours"})
            content = json.dumps(body).encode()
            connection.sendall(
                f"HTTP/1.1 {status}\r\nContent-Type: application/json\r\nContent-Length: {len(content)}\r\n"
                "Access-Control-Allow-Origin: *\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n".encode()
                + content
            )

    def _answer(self, line: str) -> tuple[str, dict[str, Any]]:
        method, _, rest = line.partition(" ")
        try:
            url = urlsplit(rest.partition(" ")[0])
        except ValueError:
            return "400 Bad Request", {"error": "the address cannot be read"}
        if (method, url.path) == ("GET", "/state"):
            return "200 OK", self._button.state()
        if (method, url.path) == ("POST", "/stop"):
            asked = parse_qs(url.query)
            self._button.press(_name(asked.get("by", [""])[0]), _moment(asked.get("pressed_at_ns", [""])[0]))
            return "200 OK", self._button.state()
        return "404 Not Found", {"error": "POST /stop?by=NAME and GET /state are what there is"}


def runtime_tag(given: str | None = None) -> str:
    """Return what distinguishes runs with a separate runtime folder: its name, it need not be there.

    ``given`` is that folder, empty for none; None for the one that this process has.
    """
    given = os.environ.get(RUNTIME, "") if given is None else given
    return hashlib.sha256(given.encode()).hexdigest()[:8] if given else "user"


@contextmanager
def listening(button: StopButton, port: int = 0) -> Iterator[Listener]:
    """Listen for presses of a button as long as the context lasts."""
    listener = Listener(button, port)
    file = _write_address(button.run, listener.port)
    try:
        yield listener
    finally:
        button.ended()
        listener.close()
        if file is not None:
            _remove_address(file)


def _write_address(run: str, port: int | None) -> Path | None:
    """Write where the listener is; None where that was not possible, since a stop waits for no file."""
    if port is None:
        return None
    try:
        file = runtime_folder() / FILE
        beside = file.with_name(f"{FILE}.{os.getpid()}")
        beside.write_text(json.dumps({"pid": os.getpid(), "port": port, "run": run}), "utf-8")
        beside.replace(file)
    except (OSError, BenchError):
        return None
    return file


def _remove_address(file: Path) -> None:
    """Take the file away, unless it is another run's by now."""
    with suppress(OSError, ValueError, KeyError, TypeError):
        if json.loads(file.read_text("utf-8"))["pid"] == os.getpid():
            file.unlink()


def _first_line(connection: socket.socket) -> str:
    """Return the request line, once the head is whole or its time is over."""
    deadline, head = time.monotonic() + _REQUEST_S, b""
    while b"\r\n\r\n" not in head and len(head) < _LONGEST:
        left = deadline - time.monotonic()
        if left <= 0.0:
            raise TimeoutError
        connection.settimeout(left)
        part = connection.recv(_LONGEST)
        if not part:
            break
        head += part
    return head.split(b"\r\n", 1)[0].decode("latin-1")


def _hang_up(connection: socket.socket) -> None:
    with suppress(OSError):
        connection.shutdown(socket.SHUT_RDWR)


def _is_own(connection: socket.socket) -> bool:
    """Whether the user of the run, or root, is at the other end."""
    raw = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    return _CREDENTIALS.unpack(raw)[1] in (0, os.geteuid())


def _name(text: str) -> str:
    printable = "".join(letter for letter in text if letter.isprintable()).strip()
    return printable[:_LONGEST_NAME] or "somebody"


def _moment(text: str) -> int | None:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 20 else None
