"""CoE emergency messages: kept as they come in, so that a drive's own words are not lost."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pysoem

from drivers.ethercat.protocols import Slave


@dataclass(frozen=True, slots=True)
class EmergencyMessage:
    """One emergency message (ETG.1000.6, 5.6.4).

    Attributes
    ----------
    slave : who sent it.
    code : emergency error code.
    register : error register (0x1001).
    data : five bytes of the maker's.
    """

    slave: str
    code: int
    register: int
    data: bytes


class EmergencyLog:
    """Collects the emergency messages of all slaves.

    Without a callback pysoem raises an emergency as an error of whatever SDO access happens to meet it.

    Parameters
    ----------
    capacity : most messages that are kept; the oldest go first.
    """

    def __init__(self, capacity: int = 256) -> None:
        self._messages: deque[EmergencyMessage] = deque(maxlen=capacity)

    def listen(self, name: str, slave: Slave) -> None:
        """Collect the messages of a slave."""

        def keep(emergency: Any) -> None:
            data = bytes([emergency.b1]) + emergency.w1.to_bytes(2, "little") + emergency.w2.to_bytes(2, "little")
            self._messages.append(EmergencyMessage(name, emergency.error_code, emergency.error_reg, data))

        slave.add_emergency_callback(keep)

    def poll(self, slaves: Sequence[Slave]) -> None:
        """Look into every mailbox once; between cycles only."""
        for slave in slaves:
            try:
                slave.mbx_receive()
            except (pysoem.SdoError, pysoem.MailboxError, pysoem.PacketError):
                continue  # the late answer to an SDO access that has long been given up: nobody waits for it

    def take(self) -> tuple[EmergencyMessage, ...]:
        """Return the messages since the last call, oldest first, and forget them."""
        taken = tuple(self._messages)
        self._messages.clear()
        return taken
