"""A line of slave controllers: every datagram of a frame passes all of them in order.

Source: ETG.1000.4 §5.4 (datagram commands, addressing, working counters). The frame is changed in place.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import ClassVar

from fakes.ethercat.wire import registers as reg
from fakes.ethercat.wire.esc import SlaveController
from fakes.ethercat.wire.logical import Plan, compile_plan, read_bits, write_bits

(NOP, APRD, APWR, APRW, FPRD, FPWR, FPRW, BRD, BWR, BRW, LRD, LWR, LRW, ARMW, FRMW) = range(15)

ETHERTYPE = 0x88A4
ETHERNET = 14
DATAGRAM = struct.Struct("<BBHHHH")
"""Command, index, address, offset, length and flags, interrupt."""

_MORE = 0x8000
_COUNTER = struct.Struct("<H")


class Segment:
    """The slaves a frame meets.

    ``process_data`` becomes True when a frame has exchanged process data; who runs the bench clears it.
    """

    def __init__(self, controllers: Sequence[SlaveController]) -> None:
        self.all = tuple(controllers)
        self.present: tuple[SlaveController, ...] = self.all
        self.silent: tuple[bool, ...] = (False,) * len(self.all)
        self.process_data = False
        self.on_change: Callable[[], None] = lambda: None
        """Called when settings of a controller have changed."""
        self._outputs_mapped = False
        self._plans: dict[tuple[int, int], Plan] = {}
        for controller in self.all:
            controller.on_change = self.forget
        self.arrange(self.all)

    def arrange(self, present: Sequence[SlaveController], silent: Sequence[bool] = ()) -> None:
        """Set which controllers frames meet, and which of them keep out of process data."""
        self.present = tuple(present)
        self.silent = tuple(silent) or (False,) * len(self.present)
        for i, controller in enumerate(self.present):
            controller.position, controller.last_position = i, len(self.present) - 1
            controller.show_ports()
        self.forget()

    def forget(self) -> None:
        """Compile anew what depends on settings of the controllers."""
        self._plans.clear()
        self._outputs_mapped = any(c.slave.exchanging and c.slave.has_outputs for c in self.present)
        self.on_change()

    def serve(self, frame: bytearray, length: int) -> bool:
        """Let a frame of ``length`` bytes pass; return False where it is none of EtherCAT's datagrams or malformed."""
        if length < ETHERNET + 2 or frame[12] != 0x88 or frame[13] != 0xA4:
            return False
        header = frame[14] | frame[15] << 8
        end = ETHERNET + 2 + (header & 0x07FF)
        if header >> 12 != 1 or end > length:
            return False
        at = ETHERNET + 2
        more = True
        while more:
            if at + DATAGRAM.size + 2 > end:
                return False
            command, _, address, offset, word, _ = DATAGRAM.unpack_from(frame, at)
            start = at + DATAGRAM.size
            stop = start + (word & 0x07FF)
            if stop + 2 > end:
                return False
            if LRD <= command <= LRW:
                added = self._logical(command, address | offset << 16, frame, start, stop)
            else:
                added, address = self._physical(command, address, offset, frame, start, stop)
                _COUNTER.pack_into(frame, at + 2, address)
            if added:
                _COUNTER.pack_into(frame, stop, (frame[stop] + (frame[stop + 1] << 8) + added) & 0xFFFF)
            more = bool(word & _MORE)
            at = stop + 2
        frame[6] |= 0x02  # a slave controller marks the source address as locally administered
        return True

    # -- physical addressing ------------------------------------------------------------------------------------

    def _physical(
        self, command: int, address: int, offset: int, frame: bytearray, start: int, stop: int
    ) -> tuple[int, int]:
        """Serve one datagram; return what the working counter gains and the address as it comes back."""
        count = len(self.present)
        serve = self._COMMANDS.get(command)
        if serve is None:
            return 0, address
        if command in (ARMW, FRMW):
            hit = -address & 0xFFFF if command == ARMW else self._find(address)
            added = self._read_multiple_write(hit, offset, frame, start, stop)
            return added, (address + count) & 0xFFFF if command == ARMW else address
        if command in (APRD, APWR, APRW):
            hit = -address & 0xFFFF
            targets = self.present[hit : hit + 1] if hit < count else ()
            address = (address + count) & 0xFFFF
        elif command in (FPRD, FPWR, FPRW):
            hit = self._find(address)
            targets = self.present[hit : hit + 1] if hit < count else ()
        else:
            targets = self.present
            address = (address + count) & 0xFFFF
        return serve(self, targets, offset, frame, start, stop), address

    def _find(self, address: int) -> int:
        for i, controller in enumerate(self.present):
            if address in (controller.station, controller.alias):
                return i
        return len(self.present)

    def _read(self, targets: Sequence[SlaveController], offset: int, frame: bytearray, start: int, stop: int) -> int:
        added = 0
        for controller in targets:
            data = controller.read(offset, stop - start)
            if data is not None:
                frame[start:stop] = data
                added += 1
        return added

    def _read_or(self, targets: Sequence[SlaveController], offset: int, frame: bytearray, start: int, stop: int) -> int:
        """Broadcast read: every slave adds its bits to those already in the frame."""
        added = 0
        for controller in targets:
            data = controller.read(offset, stop - start)
            if data is not None:
                frame[start:stop] = bytes(a | b for a, b in zip(frame[start:stop], data, strict=True))
                added += 1
        return added

    def _write(self, targets: Sequence[SlaveController], offset: int, frame: bytearray, start: int, stop: int) -> int:
        data = bytes(frame[start:stop])
        return sum(controller.write(offset, data) for controller in targets)

    def _read_write(
        self, targets: Sequence[SlaveController], offset: int, frame: bytearray, start: int, stop: int
    ) -> int:
        added = 0
        for controller in targets:
            given = bytes(frame[start:stop])
            data = controller.read(offset, stop - start)
            if data is not None:
                frame[start:stop] = data
                added += 1
            added += 2 if controller.write(offset, given) else 0
        return added

    def _read_multiple_write(self, hit: int, offset: int, frame: bytearray, start: int, stop: int) -> int:
        """One slave reads, all others write; a frame meets them in the order of the line."""
        if offset == reg.DC_SYSTEM_TIME and hit < len(self.present):
            frame[start:stop] = (self.present[hit].read(offset, stop - start) or b"").ljust(stop - start, b"\0")
            return len(self.present)
        added = 0
        for i, controller in enumerate(self.present):
            one = (controller,)
            added += (self._read if i == hit else self._write)(one, offset, frame, start, stop)
        return added

    _COMMANDS: ClassVar[dict[int, Callable[[Segment, Sequence[SlaveController], int, bytearray, int, int], int]]] = {
        APRD: _read,
        FPRD: _read,
        BRD: _read_or,
        APWR: _write,
        FPWR: _write,
        BWR: _write,
        APRW: _read_write,
        FPRW: _read_write,
        BRW: _read_write,
        ARMW: _read,
        FRMW: _read,
    }

    # -- logical addressing -------------------------------------------------------------------------------------

    def _logical(self, command: int, address: int, frame: bytearray, start: int, stop: int) -> int:
        plan = self._plans.get((address, stop - start))
        if plan is None:
            plan = compile_plan(self.present, self.silent, address, stop - start)
            self._plans[address, stop - start] = plan
        added = 0
        given = bytes(frame[start:stop]) if plan.special else b""
        if command != LRD:
            for copy in plan.writes:
                copy.controller.memory[copy.memory] = frame[start + copy.frame.start : start + copy.frame.stop]
            added += plan.write_count * (2 if command == LRW else 1)
        if command != LWR:
            for copy in plan.reads:
                frame[start + copy.frame.start : start + copy.frame.stop] = copy.controller.memory[copy.memory]
            added += plan.read_count
        for fmmu in plan.special:
            if command != LRD and fmmu.kind & 2:
                write_bits(fmmu, address, given)
            if command != LWR and fmmu.kind & 1:
                data = frame[start:stop]
                read_bits(fmmu, address, data)
                frame[start:stop] = data
        if plan.reads or plan.writes:
            # Where reads and writes come apart, the write is the cycle.
            self.process_data = self.process_data or command != LRD or not self._outputs_mapped
        return added
