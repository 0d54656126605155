"""Logical addressing: what the FMMUs of all slaves make of one logical datagram, compiled once and then only copied.

Source: ETG.1000.4 §6.6. Byte-wise entries become slice copies; entries that map single bits (a mailbox status bit, say)
take the slow way bit by bit.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass

from fakes.ethercat.wire import registers as reg
from fakes.ethercat.wire.esc import SlaveController

_ENTRY = struct.Struct("<IHBBHBBB")
READ, WRITE = 1, 2


@dataclass(frozen=True, slots=True)
class Fmmu:
    """One active entry: logical bits from ``start`` (length in bits) mapped to physical bits."""

    controller: SlaveController
    start_bit: int
    bits: int
    physical_bit: int
    kind: int


@dataclass(frozen=True, slots=True)
class Copy:
    """Bytes of a datagram that are bytes of one controller's memory; registers go through its accessors."""

    controller: SlaveController
    frame: slice
    memory: slice


@dataclass(frozen=True, slots=True)
class Plan:
    """What one logical datagram does: copies, bit entries, the working counter of its reads and writes."""

    reads: tuple[Copy, ...]
    writes: tuple[Copy, ...]
    special: tuple[Fmmu, ...]
    read_count: int
    write_count: int


def entries(controller: SlaveController) -> list[Fmmu]:
    """Return the active FMMUs of a controller."""
    found = []
    for i in range(reg.FMMU_COUNT):
        at = reg.FMMU + reg.FMMU_SIZE * i
        logical, length, first, last, physical, physical_first, kind, active = _ENTRY.unpack_from(controller.memory, at)
        if active & 1 and length:
            bits = (length - 1) * 8 + last - first + 1
            found.append(Fmmu(controller, logical * 8 + first, bits, physical * 8 + physical_first, kind))
    return found


def compile_plan(controllers: Sequence[SlaveController], silent: Sequence[bool], address: int, length: int) -> Plan:
    """Return the plan for a logical datagram of ``length`` bytes at ``address``.

    ``silent`` marks, controller by controller, those whose process data does not take part.
    """
    reads: list[Copy] = []
    writes: list[Copy] = []
    special: list[Fmmu] = []
    readers: set[int] = set()
    writers: set[int] = set()
    first, stop = address * 8, (address + length) * 8
    for n, controller in enumerate(controllers):
        for fmmu in entries(controller):
            if fmmu.start_bit >= stop or fmmu.start_bit + fmmu.bits <= first:
                continue
            register = fmmu.physical_bit < reg.RAM * 8
            if not register and (silent[n] or not controller.slave.exchanging):
                continue
            if (fmmu.start_bit | fmmu.bits | fmmu.physical_bit) % 8 or register:
                special.append(fmmu)
            else:
                copy = _copy(fmmu, address, length)
                (reads if fmmu.kind & READ else writes).append(copy)
                if fmmu.kind & READ and fmmu.kind & WRITE:
                    writes.append(copy)
            if fmmu.kind & READ:
                readers.add(n)
            if fmmu.kind & WRITE:
                writers.add(n)
    return Plan(tuple(reads), tuple(writes), tuple(special), len(readers), len(writers))


def _copy(fmmu: Fmmu, address: int, length: int) -> Copy:
    begin = max(fmmu.start_bit // 8, address)
    end = min((fmmu.start_bit + fmmu.bits) // 8, address + length)
    physical = fmmu.physical_bit // 8 + begin - fmmu.start_bit // 8
    return Copy(fmmu.controller, slice(begin - address, end - address), slice(physical, physical + end - begin))


def read_bits(fmmu: Fmmu, address: int, data: bytearray) -> None:
    """Copy the bits of a special entry from memory into the data of a datagram."""
    value = int.from_bytes(_physical(fmmu), "little") >> fmmu.physical_bit % 8
    for i in range(fmmu.bits):
        bit = fmmu.start_bit + i - address * 8
        if 0 <= bit < len(data) * 8:
            mask = 1 << bit % 8
            data[bit // 8] = data[bit // 8] & ~mask | (mask if value >> i & 1 else 0)


def write_bits(fmmu: Fmmu, address: int, data: bytes) -> None:
    """Copy the bits of a special entry from the data of a datagram into memory."""
    held = int.from_bytes(_physical(fmmu), "little")
    for i in range(fmmu.bits):
        bit = fmmu.start_bit + i - address * 8
        if 0 <= bit < len(data) * 8:
            mask = 1 << (fmmu.physical_bit % 8 + i)
            held = held | mask if data[bit // 8] >> bit % 8 & 1 else held & ~mask
    first, count = _extent(fmmu)
    fmmu.controller.write(first, held.to_bytes(count, "little"))


def _extent(fmmu: Fmmu) -> tuple[int, int]:
    first = fmmu.physical_bit // 8
    return first, (fmmu.physical_bit + fmmu.bits + 7) // 8 - first


def _physical(fmmu: Fmmu) -> bytes:
    first, count = _extent(fmmu)
    return fmmu.controller.read(first, count) or bytes(count)
