"""JSON lines over a Unix socket: a run sends to whoever listens, takes the operator's wishes, and waits for nobody."""

from __future__ import annotations

import contextlib
import json
import queue
import socket
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

Message = dict[str, Any]
_MOST_WAITING = 2000
"""Messages that may wait for a listener; one who lags further behind is disconnected and may connect again."""
_LIVE_UNTIL = 200
"""Above so many waiting messages live values are left out: states matter more."""
_LIVE = frozenset({"live", "spectrum", "condition"})


class LineServer:
    """Listens on a Unix socket; every message goes to every listener, every line from a listener to ``receive``.

    Parameters
    ----------
    path : of the socket; readable and writable by its owner only.
    greeting : gives the messages a new listener starts with.
    receive : is called with each message from a listener, on its thread.
    """

    def __init__(self, path: Path, greeting: Callable[[], list[Message]], receive: Callable[[Message], None]) -> None:
        self._path, self._greeting, self._receive = path, greeting, receive
        self._lock = threading.Lock()
        self._listeners: list[_Listener] = []
        path.unlink(missing_ok=True)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.bind(str(path))
        path.chmod(0o600)
        self._socket.listen(4)
        threading.Thread(target=self._accept, name="listeners", daemon=True).start()

    def send(self, message: Message) -> None:
        """Hand a message to every listener; returns at once whatever they do."""
        with self._lock:
            self._listeners = [listener for listener in self._listeners if listener.offer(message)]

    def close(self, wait_s: float = 2.0) -> None:
        """Give listeners a moment to read what waits, then end."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()
        self._path.unlink(missing_ok=True)
        with self._lock:
            listeners, self._listeners = self._listeners, []
        for listener in listeners:
            listener.finish(wait_s)

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:
                return
            listener = _Listener(connection, self._receive)
            with self._lock:
                # under the lock: nothing may come between the greeting and what follows it
                for message in self._greeting():
                    listener.offer(message)
                self._listeners.append(listener)


class _Listener:
    def __init__(self, connection: socket.socket, receive: Callable[[Message], None]) -> None:
        self._connection, self._receive = connection, receive
        self._waiting: queue.Queue[Message | None] = queue.Queue()
        self._dead = False
        self._sender = threading.Thread(target=self._send, name="to-listener", daemon=True)
        self._sender.start()
        threading.Thread(target=self._read, name="from-listener", daemon=True).start()

    def offer(self, message: Message) -> bool:
        """Queue a message; False if this listener is gone."""
        waiting = self._waiting.qsize()
        if self._dead or waiting > _MOST_WAITING:
            self._hang_up()
            return False
        if message["type"] not in _LIVE or waiting <= _LIVE_UNTIL:
            # written as text on the listener's own thread: whoever sends does not wait for that either
            self._waiting.put(message)
        return True

    def finish(self, wait_s: float) -> None:
        """Let the sender empty its queue for a moment."""
        self._waiting.put(None)
        self._sender.join(wait_s)
        self._hang_up()

    def _hang_up(self) -> None:
        # closing alone neither wakes the threads that wait in it nor informs the other end while one of them does
        with contextlib.suppress(OSError):
            self._connection.shutdown(socket.SHUT_RDWR)
        self._connection.close()

    def _send(self) -> None:
        try:
            while (message := self._waiting.get()) is not None:
                self._connection.sendall(json.dumps(message, allow_nan=False).encode() + b"\n")
        except OSError:
            self._dead = True

    def _read(self) -> None:
        try:
            with self._connection.makefile("rb") as lines:
                for line in lines:
                    try:
                        message = json.loads(line)
                    except ValueError:
                        continue
                    if isinstance(message, dict):
                        self._receive(message)
        except (OSError, ValueError):
            self._dead = True
