"""The claim on a network interface: of all programs of this computer one at a time may be its master.

A name in the kernel's abstract socket space, taken as long as the bus is open: it needs no folder, counts for all users
and goes with its process, however that ends. A bus process whose rig was killed keeps it until the drives are at rest.
"""

from __future__ import annotations

import errno
import socket
import struct
from contextlib import suppress
from pathlib import Path

from drivers.errors import BusError

_NAME = "gearbench-bus-"
_INTERFACES = Path("/sys/class/net")
_CREDENTIALS = struct.Struct("3i")


class Claim:
    """Of one interface; nothing is claimed where the kernel knows no interface of that name."""

    def __init__(self, interface: str) -> None:
        self._interface = interface
        self._socket: socket.socket | None = None

    def take(self) -> None:
        """Claim the interface.

        Raises
        ------
        BusError
            If another program has it.
        """
        # an emulated master in this process has no interface, and of those any number may be
        if self._socket is not None or "/" in self._interface or not (_INTERFACES / self._interface).exists():
            return
        claim = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            claim.bind(f"\0{_NAME}{self._interface}")
        except OSError as error:
            claim.close()
            if error.errno != errno.EADDRINUSE:
                raise BusError(f"network interface '{self._interface}' cannot be claimed: {error}") from error
            raise BusError(
                f"network interface '{self._interface}' is in use by another master{_holder(self._interface)}; two"
                " masters on a wire throw each other's drives into faults: wait for its end"
            ) from error
        claim.listen(1)
        self._socket = claim

    def release(self) -> None:
        """Let others have it."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def _holder(interface: str) -> str:
    """Return who has it, as far as the kernel says."""
    with suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        probe.settimeout(0.2)
        probe.connect(f"\0{_NAME}{interface}")
        raw = probe.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
        return f" (process {_CREDENTIALS.unpack(raw)[0]})"
    return ""
