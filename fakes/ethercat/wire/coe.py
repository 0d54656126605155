"""CoE over the mailbox: SDO transfers, SDO information, emergency (ETG.1000.6 §5.6).

:meth:`CoeServer.serve` takes one mailbox message (mailbox header included) and returns the answers, none or more.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from fakes.ethercat.objects import aborts
from fakes.ethercat.objects.aborts import SdoAbort
from fakes.ethercat.slaves.slave import Slave
from fakes.ethercat.wire import sdo_info

HEADER = struct.Struct("<HHBB")
"""Mailbox header: length of what follows, station address, channel and priority, type and counter."""

COE = 3
EMERGENCY, SDO_REQUEST, SDO_RESPONSE, SDO_INFORMATION = 1, 2, 3, 8
UNSUPPORTED_PROTOCOL, SERVICE_NOT_SUPPORTED, SIZE_TOO_SHORT = 0x0002, 0x0004, 0x0006
_COMPLETE = 0x10
_TOGGLE = 0x10


@dataclass(slots=True)
class _Transfer:
    """A segmented transfer under way."""

    index: int
    subindex: int
    complete: bool
    data: bytearray
    size: int
    toggle: int = 0


class CoeServer:
    """SDO server of one slave; ``capacity`` is the length of its send mailbox in bytes."""

    def __init__(self, slave: Slave, capacity: int) -> None:
        self._slave = slave
        self.capacity = capacity
        self._download: _Transfer | None = None
        self._upload: _Transfer | None = None
        self._counter = 0

    def serve(self, message: bytes) -> list[bytes]:
        """Return the answers to one mailbox message."""
        length, _, _, kind = HEADER.unpack_from(message)
        body = message[HEADER.size : HEADER.size + length]
        if kind & 0x0F != COE:
            return [self._error(UNSUPPORTED_PROTOCOL)]
        if len(body) < 3 or len(body) < length:
            return [self._error(SIZE_TOO_SHORT)]
        service = int.from_bytes(body[:2], "little") >> 12
        if service == SDO_REQUEST:
            return [self._coe(*answer) for answer in self._sdo(body[2:].ljust(8, b"\0"))]
        if service == SDO_INFORMATION:
            room = self.capacity - HEADER.size - 2
            return [
                self._coe(SDO_INFORMATION, part) for part in sdo_info.answer(self._slave.dictionary, body[2:], room)
            ]
        return [self._error(SERVICE_NOT_SUPPORTED)]

    def emergency(self) -> bytes | None:
        """Return the next emergency that waits, as a message."""
        if not self._slave.emergencies:
            return None
        found = self._slave.emergencies.pop(0)
        return self._coe(EMERGENCY, struct.pack("<HB5s", found.code, found.register, found.data))

    def _coe(self, service: int, body: bytes) -> bytes:
        return self._message(COE, struct.pack("<H", service << 12) + body)

    def _error(self, code: int) -> bytes:
        return self._message(0, struct.pack("<HH", 1, code))

    def _message(self, kind: int, body: bytes) -> bytes:
        self._counter = self._counter % 7 + 1
        return HEADER.pack(len(body), 0, 0, kind | self._counter << 4) + body

    # -- SDO ----------------------------------------------------------------------------------------------------

    def _sdo(self, body: bytes) -> list[tuple[int, bytes]]:
        command, index, subindex = struct.unpack_from("<BHB", body)
        serve = self._COMMANDS.get(command >> 5)
        try:
            if serve is None:
                raise SdoAbort(aborts.COMMAND)
            answer = serve(self, command, index, subindex, body)
        except SdoAbort as abort:
            open_ = self._download or self._upload
            if command >> 5 in (0, 3) and open_ is not None:
                index, subindex = open_.index, open_.subindex
            self._download = self._upload = None
            return [(SDO_REQUEST, struct.pack("<BHBI", 0x80, index, subindex, abort.code))]
        return [] if answer is None else [(SDO_RESPONSE, answer)]

    def _start_download(self, command: int, index: int, subindex: int, body: bytes) -> bytes | None:
        complete = bool(command & _COMPLETE)
        if command & 0x02:
            size = 4 - (command >> 2 & 3) if command & 0x01 else 4
            self._write(index, subindex, complete, body[4 : 4 + size])
        else:
            (size,) = struct.unpack_from("<I", body, 4)
            data = bytearray(body[8 : 8 + size])
            transfer = _Transfer(index, subindex, complete, data, size)
            if len(data) < size:
                self._slave.dictionary.entry(index, subindex)
                self._download = transfer
            else:
                self._write(index, subindex, complete, bytes(data))
        return struct.pack("<BHBI", 0x60 | command & _COMPLETE, index, subindex, 0)

    def _download_segment(self, command: int, index: int, subindex: int, body: bytes) -> bytes | None:
        transfer = self._download
        if transfer is None:
            raise SdoAbort(aborts.COMMAND)
        if command & _TOGGLE != transfer.toggle:
            raise SdoAbort(aborts.TOGGLE)
        unused = command >> 1 & 7
        part = body[1 : 8 - unused] if len(body) <= 8 else body[1:]
        transfer.data += part[: transfer.size - len(transfer.data)]
        transfer.toggle ^= _TOGGLE
        if command & 0x01:
            self._download = None
            if len(transfer.data) != transfer.size:
                raise SdoAbort(aborts.TOO_SHORT)
            self._write(transfer.index, transfer.subindex, transfer.complete, bytes(transfer.data))
        return struct.pack("<B7x", 0x20 | command & _TOGGLE)

    def _start_upload(self, command: int, index: int, subindex: int, body: bytes) -> bytes | None:
        complete = bool(command & _COMPLETE)
        dictionary = self._slave.dictionary
        data = (dictionary.read_complete if complete else dictionary.read)(index, subindex)
        flags = command & _COMPLETE
        if 1 <= len(data) <= 4:
            head = struct.pack("<BHB", 0x43 | flags | (4 - len(data)) << 2, index, subindex)
            return head + data.ljust(4, b"\0")
        room = self.capacity - HEADER.size - 10
        head = struct.pack("<BHBI", 0x41 | flags, index, subindex, len(data))
        if len(data) > room:
            self._upload = _Transfer(index, subindex, complete, bytearray(data[room:]), len(data))
        return head + data[:room]

    def _upload_segment(self, command: int, index: int, subindex: int, body: bytes) -> bytes | None:
        transfer = self._upload
        if transfer is None:
            raise SdoAbort(aborts.COMMAND)
        if command & _TOGGLE != transfer.toggle:
            raise SdoAbort(aborts.TOGGLE)
        room = self.capacity - HEADER.size - 3
        part = bytes(transfer.data[:room])
        del transfer.data[:room]
        last = 0 if transfer.data else 0x01
        if last:
            self._upload = None
        transfer.toggle ^= _TOGGLE
        unused = max(0, 7 - len(part))
        return bytes([command & _TOGGLE | unused << 1 | last]) + part.ljust(7, b"\0")

    def _abort(self, command: int, index: int, subindex: int, body: bytes) -> bytes | None:
        self._download = self._upload = None
        return None

    def _write(self, index: int, subindex: int, complete: bool, data: bytes) -> None:
        dictionary = self._slave.dictionary
        write = dictionary.write_complete if complete else dictionary.write
        write(index, subindex, data, int(self._slave.al.state))

    _COMMANDS: ClassVar[dict[int, Callable[[CoeServer, int, int, int, bytes], bytes | None]]] = {
        0: _download_segment,
        1: _start_download,
        2: _start_upload,
        3: _upload_segment,
        4: _abort,
    }
