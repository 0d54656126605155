"""A raw Ethernet socket that sees EtherCAT frames only (Linux AF_PACKET; needs CAP_NET_RAW)."""

from __future__ import annotations

import socket
import struct

from fakes.ethercat.wire.segment import ETHERTYPE

_PACKET_IGNORE_OUTGOING = 23
_SOL_PACKET = 263


class PortError(OSError):
    """The interface cannot be opened."""


class Port:
    """One network interface.

    Parameters
    ----------
    interface : its name.
    wait_s : longest time :meth:`receive` waits.

    Raises
    ------
    PortError : no such interface, or raw sockets are not allowed.
    """

    def __init__(self, interface: str, wait_s: float = 0.004) -> None:
        self._claim = _claim(interface)
        try:
            self._socket = _raw_socket(interface)
        except PortError:
            self._claim.close()
            raise
        micro = round(wait_s * 1e6)
        self._socket.setsockopt(
            socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("@ll", micro // 1_000_000, micro % 1_000_000)
        )

    def receive(self, frame: bytearray) -> int:
        """Wait for a frame and put it into ``frame``; return its length, 0 where none came in time."""
        try:
            return self._socket.recv_into(frame)
        except (BlockingIOError, InterruptedError):
            return 0

    def send(self, frame: memoryview) -> None:
        """Send a frame; one the interface has no room for is lost, as on a wire."""
        try:
            self._socket.send(frame)
        except (BlockingIOError, OSError) as error:
            if isinstance(error, OSError) and error.errno not in _LOSSES:
                raise

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
        self._claim.close()


def _raw_socket(interface: str) -> socket.socket:
    made = None
    try:
        made = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERTYPE))
        made.setsockopt(_SOL_PACKET, _PACKET_IGNORE_OUTGOING, 1)
        made.bind((interface, ETHERTYPE))
    except OSError as error:
        if made is not None:
            made.close()
        reason = "raw sockets are not allowed here, CAP_NET_RAW is needed" if made is None else str(error)
        raise PortError(f"network interface {interface} cannot be opened: {reason}") from error
    return made


def _claim(interface: str) -> socket.socket:
    """Hold a name for the interface: frames that two emulators answer are answered twice, and nothing works."""
    claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        claim.bind(f"\0bench-emulate-{interface}")
    except OSError as error:
        claim.close()
        raise PortError(f"another emulator answers on {interface} already: end it first") from error
    return claim


_LOSSES = frozenset({11, 100, 105})
"""EAGAIN, ENETDOWN, ENOBUFS: the frame is lost."""
