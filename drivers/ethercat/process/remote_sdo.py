"""Object dictionary of a slave, reached through the bus process."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from drivers.ethercat.sdo import SdoClient


class RemoteSdo(SdoClient):
    """:class:`SdoClient` whose accesses happen between two cycles of the bus process.

    Parameters
    ----------
    ask : sends a verb and its arguments to the process and returns its answer.
    name : of the slave.
    """

    def __init__(self, ask: Callable[..., Any], name: str) -> None:
        self.name = name
        self._ask = ask

    def read_bytes(self, index: int, subindex: int, size: int = 0) -> bytes:
        """Raw content of an object, as :meth:`SdoClient.read_bytes`."""
        data: bytes = self._ask("sdo", self.name, "read_bytes", index, subindex, size)
        return data

    def write(self, index: int, subindex: int, type_: str, value: int) -> None:
        """Write an integer, as :meth:`SdoClient.write`."""
        self._ask("sdo", self.name, "write", index, subindex, type_, value)
