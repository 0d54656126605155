"""The HTTP server's patience: a request has to be whole in time, and only so many may be half open.

Without it whoever opens a thousand connections and sends nothing keeps everybody else out, and STOP with them.
"""

from __future__ import annotations

import asyncio
import resource
from typing import TYPE_CHECKING, ClassVar

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

if TYPE_CHECKING:
    from asyncio import TimerHandle, Transport

WHOLE_S = 10.0
"""A request that is not whole so long after its connection or its first byte is hung up on."""
MOST_HALF_OPEN = 128
"""So many requests may be half open; for each further one the oldest is hung up on."""
_DESCRIPTORS = 8192
_INCOMPLETE = (h11.IDLE, h11.SEND_BODY)


class PatientProtocol(H11Protocol):
    """HTTP/1.1 as uvicorn speaks it, with an end to waiting."""

    half_open: ClassVar[dict[PatientProtocol, None]] = {}
    """Connections whose request is not whole, oldest first; of the one server of this process."""
    _late: TimerHandle | None = None

    def connection_made(self, transport: Transport) -> None:  # type: ignore[override]
        """Wait for the first request, not for ever."""
        super().connection_made(transport)
        self._wait()

    def data_received(self, data: bytes) -> None:
        """Take data; wait further if the request is not whole yet."""
        super().data_received(data)
        if self.conn.their_state in _INCOMPLETE and not self._is_between_requests():
            self._wait()
        else:
            self._wait_no_more()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        self._wait_no_more()
        super().connection_lost(exc)

    def _is_between_requests(self) -> bool:
        """Whether a request has been answered and no byte of another one has come."""
        return self.conn.their_state is h11.IDLE and not self.conn.trailing_data[0]

    def _wait(self) -> None:
        if self._late is not None:
            return
        self._late = asyncio.get_running_loop().call_later(WHOLE_S, self._hang_up)
        self.half_open[self] = None
        if len(self.half_open) > MOST_HALF_OPEN:
            next(iter(self.half_open))._hang_up()

    def _wait_no_more(self) -> None:
        if self._late is not None:
            self._late.cancel()
            self._late = None
        self.half_open.pop(self, None)

    def _hang_up(self) -> None:
        self._wait_no_more()
        self.transport.abort()


def allow_descriptors() -> None:
    """Let this process have as many open connections as a crowd of half-open ones needs until it is hung up on."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = _DESCRIPTORS if hard == resource.RLIM_INFINITY else min(_DESCRIPTORS, hard)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
