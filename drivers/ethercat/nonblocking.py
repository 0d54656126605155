"""Let a missing frame cost what the timeout says: O_NONBLOCK on the master's own raw socket, and a wait that sleeps.

SOEM sets SO_RCVTIMEO to 1 µs, which the kernel rounds up to a jiffy: a lost frame then blocks for 8 to 12 ms. With the
socket non-blocking, SOEM polls it until its own timeout and burns the processor meanwhile, which on a shared core is
just what the one who answers would need. So the wait for a frame is a ``select`` of our own, to the microsecond; SOEM
is asked when there is something to read.
"""

from __future__ import annotations

import os
import select
import socket
import stat
from pathlib import Path

_FAMILY = getattr(socket, "AF_PACKET", None)
_MOST_STALE, _FRAME_BYTES = 64, 2048
_MOST_BEHIND = 4096
"""Frames that are dropped at most where no cycle waits: more than SOEM sends while a silent slave is asked."""


def packet_sockets() -> frozenset[int]:
    """File descriptors of this process that are raw packet sockets."""
    return frozenset(fd for fd in _descriptors() if _is_packet_socket(fd))


def set_nonblocking(descriptors: frozenset[int]) -> int:
    """Set O_NONBLOCK on each descriptor; returns how many there were."""
    for fd in descriptors:
        os.set_blocking(fd, False)
    return len(descriptors)


class FrameWait:
    """Sleeps until a frame has come, or patience is over.

    Parameters
    ----------
    descriptor : raw socket of the master.
    patience_us : longest wait, µs.
    """

    def __init__(self, descriptor: int, patience_us: int) -> None:
        self._sockets = [descriptor]
        self._patience_s = patience_us * 1e-6
        self._poll = select.poll()
        self._poll.register(descriptor, select.POLLIN)

    def __call__(self) -> bool:
        """Whether there is something to read."""
        return bool(select.select(self._sockets, (), (), self._patience_s)[0])

    def drain(self) -> None:
        """Drop what has come, as :func:`drain`."""
        _drop(self._sockets[0], self._poll, _MOST_STALE)


def drain(descriptor: int) -> None:
    """Drop every frame that has come; at most a bounded number, in case they come without end.

    SOEM numbers its frames modulo 16 and takes an old one of the same number for the answer to a new one; where one is
    late, all that follow may be.
    """
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    _drop(descriptor, poll, _MOST_BEHIND)


def _drop(descriptor: int, poll: select.poll, most: int) -> None:
    for _ in range(most):
        if not any(event & select.POLLIN for _, event in poll.poll(0)):
            return
        try:
            os.read(descriptor, _FRAME_BYTES)
        except OSError:  # the interface has gone: nothing comes any more, and the next frame that is sent says so
            return


def _descriptors() -> list[int]:
    folder = Path("/proc/self/fd")
    return [int(entry.name) for entry in folder.iterdir()] if folder.is_dir() else []


def _is_packet_socket(fd: int) -> bool:
    try:
        if not stat.S_ISSOCK(os.fstat(fd).st_mode):
            return False
    except OSError:  # closed between listing and looking: the listing's own descriptor, for one
        return False
    duplicate = socket.socket(fileno=os.dup(fd))
    try:
        return _FAMILY is not None and duplicate.family == _FAMILY
    finally:
        duplicate.close()
