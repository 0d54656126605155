"""Mailbox sync managers: SM0 takes requests, SM1 holds answers; full and empty as the standard's handshake has them.

Source: ETG.1000.4 §6.7 (mailbox mode), ETG.1000.6 §5.4. A request is complete when the last byte of the buffer is
written, an answer is gone when its last byte is read. Until then access from the other side is refused (working
counter 0). A request that comes twice with the same counter was sent again because the frame was late: it is served
once (ETG.1000.4 §5.6: counter of the mailbox header, 1 to 7, 0 is not counted).
"""

from __future__ import annotations

from collections import deque

from fakes.ethercat.slaves.slave import Slave
from fakes.ethercat.wire import registers as reg
from fakes.ethercat.wire.coe import HEADER, CoeServer

_OUT, _IN = reg.SYNC_MANAGER, reg.SYNC_MANAGER + reg.SYNC_MANAGER_SIZE
_STATUS, _ACTIVATE, _PDI = 5, 6, 7
_REPEAT = 0x02


class Mailbox:
    """Both mailboxes of a slave in the memory of its controller."""

    def __init__(self, memory: bytearray, slave: Slave) -> None:
        self._memory = memory
        self._slave = slave
        self._server = CoeServer(slave, 256)
        self._waiting: deque[bytes] = deque()
        self.reset()

    def reset(self) -> None:
        """Be empty and off."""
        self._waiting.clear()
        self._last = b""
        self._out = self._in = (0, 0)
        self._repeat = 0
        self._served = 0

    def empty(self) -> None:
        """Throw away what waits, as a slave does on its way to INIT."""
        self._waiting.clear()
        self._last = b""
        self._served = 0
        self._full(_OUT, False)
        self._full(_IN, False)

    def configure(self) -> None:
        """Take over what the master wrote to SM0 and SM1."""
        out, in_ = self._range(_OUT), self._range(_IN)
        if (out, in_) != (self._out, self._in):
            self._out, self._in = out, in_
            self._server = CoeServer(self._slave, max(in_[1] - in_[0], 16))
            self._waiting.clear()
            self._served = 0
            self._full(_OUT, False)
            self._full(_IN, False)
        repeat = self._memory[_IN + _ACTIVATE] & _REPEAT
        if repeat != self._repeat:
            self._repeat = repeat
            if self._last:
                self._waiting.appendleft(self._last)
                self._full(_IN, False)
                self.fill()
            self._memory[_IN + _PDI] = self._memory[_IN + _PDI] & ~_REPEAT | repeat

    def blocks_read(self, address: int, length: int) -> bool:
        """Whether a read touches an answer buffer that is empty."""
        start, stop = self._in
        touches = address < stop and address + length > start
        return touches and not self._memory[_IN + _STATUS] & reg.MAILBOX_FULL

    def after_read(self, address: int, length: int) -> None:
        """Release the answer whose last byte was read, and bring up the next."""
        start, stop = self._in
        if start <= address < stop <= address + length:
            self._full(_IN, False)
            self.fill()

    def blocks_write(self, address: int) -> bool:
        """Whether a write goes to a request buffer that is still full."""
        start, stop = self._out
        return start <= address < stop and bool(self._memory[_OUT + _STATUS] & reg.MAILBOX_FULL)

    def after_write(self, stop: int) -> None:
        """Serve the request whose last byte was written, unless it is the one before, sent again."""
        first, last = self._out
        if first == last or stop != last:
            return
        message = bytes(self._memory[first:last])
        counter = HEADER.unpack_from(message)[3] >> 4 & 0x07
        if counter and counter == self._served:
            return
        self._served = counter
        self._waiting.extend(self._server.serve(message))
        self.fill()

    def fill(self) -> None:
        """Put the next message that waits, an emergency first, into the empty answer buffer."""
        start, stop = self._in
        if start == stop or self._memory[_IN + _STATUS] & reg.MAILBOX_FULL:
            return
        message = self._server.emergency() or (self._waiting.popleft() if self._waiting else b"")
        if message:
            self._last = message
            self._memory[start:stop] = message.ljust(stop - start, b"\0")
            self._full(_IN, True)

    def _range(self, at: int) -> tuple[int, int]:
        if not self._memory[at + _ACTIVATE] & 0x01:
            return 0, 0
        start = int.from_bytes(self._memory[at : at + 2], "little")
        return start, start + int.from_bytes(self._memory[at + 2 : at + 4], "little")

    def _full(self, at: int, full: bool) -> None:
        status = self._memory[at + _STATUS]
        self._memory[at + _STATUS] = status | reg.MAILBOX_FULL if full else status & ~reg.MAILBOX_FULL
