"""What the bus process looks at in every cycle, and the stop it does by itself; no arrays, they cost too much."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from enum import IntEnum

import numpy as np

from drivers.entries import entries_dtype
from drivers.ethercat.process.settings import Condition, Protection, Watch
from drivers.ethercat.slave import SlaveSpec


class Reason(IntEnum):
    """Why the bus process stopped the drives by itself; the number stands in the shared memory."""

    NONE = 0
    STARVED = 1
    RIG_GONE = 2
    ORDERED = 3
    TERMINATED = 4
    WORKING_COUNTER = 5
    LIMIT = 6

    @property
    def text(self) -> str:
        """Words for a sentence."""
        return _TEXT[self]


_TEXT: Mapping[Reason, str] = {
    Reason.NONE: "nothing",
    Reason.STARVED: "the rig gave no set values in time",
    Reason.RIG_GONE: "the rig's process has ended",
    Reason.ORDERED: "the rig ordered it",
    Reason.TERMINATED: "the bus process was asked to end",
    Reason.WORKING_COUNTER: "too many cycles in a row had a wrong working counter",
    Reason.LIMIT: "an input went beyond its limit",
}

Place = tuple[struct.Struct, int]
"""How to read an entry out of the inputs' bytes: format, offset."""


def places(slaves: tuple[SlaveSpec, ...]) -> dict[tuple[str, str], Place]:
    """Return where every integer input entry is in a row of the process image, by (slave, entry)."""
    found: dict[tuple[str, str], Place] = {}
    start = 0
    for spec in slaves:
        dtype = entries_dtype(spec.inputs)
        for name, (kind, offset) in ((name, field[:2]) for name, field in (dtype.fields or {}).items()):
            found[spec.name, name] = struct.Struct("<" + np.dtype(kind).char), start + offset
        start += dtype.itemsize
    return found


class _Watched:
    """One watch, compiled to what a cycle needs."""

    __slots__ = ("count", "high", "low", "offset", "patience", "read")

    def __init__(self, watch: Watch, place: Place) -> None:
        self.read, self.offset = place[0].unpack_from, place[1]
        self.low, self.high, self.patience = watch.low, watch.high, watch.patience
        self.count = 0


class Guard:
    """Judges cycles and walks through the steps of a stop.

    Parameters
    ----------
    protection : limits and steps.
    slaves : whose inputs the process image holds.
    expected_wkc : working counter of an undisturbed cycle.
    """

    def __init__(self, protection: Protection, slaves: tuple[SlaveSpec, ...], expected_wkc: int) -> None:
        where = places(slaves)
        self.steps = protection.steps
        self._until = [[_compile(condition, where) for condition in step.until] for step in protection.steps]
        self._watched = [_Watched(watch, where[watch.slave, watch.entry]) for watch in protection.watches]
        self._bad_cycles, self._expected = protection.bad_cycles, expected_wkc
        self._bad = 0
        self._step = self._elapsed = 0
        self.broken = -1
        """Which watch was broken."""

    def judge(self, inputs: memoryview, wkc: int) -> Reason:
        """Return why the drives must be stopped, or NONE, after a cycle whose inputs are given."""
        if wkc != self._expected:
            self._bad += 1
            return Reason.WORKING_COUNTER if self._bad >= self._bad_cycles else Reason.NONE
        self._bad = 0
        for number, watched in enumerate(self._watched):
            value = watched.read(inputs, watched.offset)[0]
            if watched.low <= value <= watched.high:
                watched.count = 0
                continue
            watched.count += 1
            if watched.count >= watched.patience:
                self.broken = number
                return Reason.LIMIT
        return Reason.NONE

    def start(self, reason: Reason) -> None:
        """Begin the stop: at the first step, or at the last one where a drive cannot be trusted.

        A drive that is beyond its limit may have a wrong encoder, and would ramp down from a speed that never was.
        """
        self._step = len(self.steps) - 1 if reason is Reason.LIMIT else 0
        self._elapsed = 0

    def clear(self) -> None:
        """Forget what was counted, after the operator's acknowledgement."""
        self._bad, self.broken = 0, -1
        for watched in self._watched:
            watched.count = 0

    @property
    def outputs(self) -> bytes:
        """What the stop sends now."""
        return self.steps[self._step].outputs

    def advance(self, inputs: memoryview, wkc: int) -> bool:
        """Go on after a cycle of the stop; True when it is over (the last step's outputs go on being sent)."""
        self._elapsed += 1
        until = self._until[self._step]
        done = bool(until) and wkc == self._expected and all(_holds(condition, inputs) for condition in until)
        if not done and self._elapsed < self.steps[self._step].cycles:
            return False
        if self._step == len(self.steps) - 1:
            return True
        self._step, self._elapsed = self._step + 1, 0
        return False


_Compiled = tuple[struct.Struct, int, int, int]


def _compile(condition: Condition, where: Mapping[tuple[str, str], Place]) -> _Compiled:
    read, offset = where[condition.slave, condition.entry]
    return read, offset, condition.mask, condition.value


def _holds(condition: _Compiled, inputs: memoryview) -> bool:
    read, offset, mask, value = condition
    return bool(read.unpack_from(inputs, offset)[0] & mask == value)
