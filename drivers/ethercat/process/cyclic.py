"""The cycle of the bus process: set values out of one ring, images into the other, and a stop of its own if need be."""

from __future__ import annotations

from collections.abc import Callable

from drivers.ethercat.pacing import AbsoluteDeadlines
from drivers.ethercat.process import layout as at
from drivers.ethercat.process.guard import Guard, Reason
from drivers.ethercat.process.layout import CYCLING, META, STOPPED, STOPPING, Shared

_LOOK_EVERY = 16
"""Cycles between two looks at the rig's pipe: a look is a system call."""


class Cyclic:
    """Runs cycles until it is asked to leave.

    Parameters
    ----------
    shared : the memory shared with the rig.
    run_row : sends and fills one row of the image ring; returns the working counter.
    pacing : when cycles are due.
    clock : monotonic time, ns.
    look : handles what the rig asks between cycles; False when the rig has gone.
    """

    def __init__(
        self,
        shared: Shared,
        run_row: Callable[[int], int],
        pacing: AbsoluteDeadlines,
        clock: Callable[[], int],
        look: Callable[[], bool],
    ) -> None:
        self._run_row, self._pacing, self._clock, self._look = run_row, pacing, clock, look
        self._words = shared.words
        memory, layout = memoryview(shared.map), shared.layout
        self._memory, self._layout = memory, layout
        self._last = bytes(layout.out_width)
        self._next = self._count = self._held = 0
        self._sent = -1
        """Which set values ``_last`` holds; −1 where they are none that were handed over."""
        self._mode = CYCLING
        self._resumed = 0
        self.guard: Guard | None = None
        self.leaving = False
        self.end_when_stopped = False
        """The rig has gone or the process was asked to end: leave once the drives are at rest."""

    def start(self, outputs: bytes) -> None:
        """Hold these outputs until there are set values."""
        self._last = outputs
        self._words[at.STATE] = CYCLING

    def stop(self, reason: Reason) -> None:
        """Begin the stop, unless one is on already."""
        if self._mode != CYCLING:
            return
        self._words[at.STOP_IMAGE] = self._count
        self._words[at.DETAIL] = -1 if self.guard is None else self.guard.broken
        self._words[at.STOP_REASON] = reason
        if self.guard is None or not self.guard.steps:
            # nobody has said how drives are stopped: without set values of their own they keep the last outputs of all
            self._last = bytes(self._layout.out_width)
            self._mode = STOPPED
        else:
            self.guard.start(reason)
            self._mode = STOPPING
        self._words[at.STATE] = self._mode

    def run(self) -> None:
        """Cycle until :attr:`leaving`."""
        layout, words, memory, clock = self._layout, self._words, self._memory, self._clock
        out_width, in_width = layout.out_width, layout.in_width
        pack, next_slot, run_row, pacing = META.pack_into, self._pacing.next_slot, self._run_row, self._pacing
        while not self.leaving:
            slot, woke = next_slot()
            index = self._choose()
            row = self._count % layout.image_rows
            place = layout.sent + row * out_width
            memory[place : place + out_width] = self._last
            wkc = run_row(row)
            back = clock()
            place = layout.inputs + row * in_width
            self._judge(memory[place : place + in_width], wkc)
            pack(
                memory,
                layout.meta + row * META.size,
                slot,
                pacing.due_ns,
                woke,
                back,
                clock(),
                index,
                wkc,
                self._mode,
            )
            self._count += 1
            words[at.IMAGE_HEAD] = self._count
            if self._count % _LOOK_EVERY == 0:
                self._attend()

    def _choose(self) -> int:
        """Put the outputs of this cycle into ``_last``; return which set values they are."""
        words = self._words
        if self._mode != CYCLING:
            # what the rig hands over meanwhile is not wanted any more
            self._next = words[at.SET_NEXT] = words[at.SET_HEAD]
            if self.guard is not None and self.guard.steps:
                self._last = self.guard.outputs
            self._sent = -1
            return -1
        skip = words[at.SKIP_TO]
        if skip > self._next:
            self._next = words[at.SET_NEXT] = skip
        if self._next < words[at.SET_HEAD]:
            place = self._layout.set_values + self._next % self._layout.set_rows * self._layout.out_width
            self._last = bytes(self._memory[place : place + self._layout.out_width])
            self._sent = self._next
            self._next += 1
            words[at.SET_USED] = words[at.SET_NEXT] = self._next
            self._held = 0
            return self._sent
        limit = words[at.HOLD_LIMIT]
        self._held = self._held + 1 if limit else 0
        if self._held > limit:
            self.stop(Reason.STARVED)
        return self._sent

    def _judge(self, inputs: memoryview, wkc: int) -> None:
        guard = self.guard
        if guard is None:
            return
        if self._mode == CYCLING:
            reason = guard.judge(inputs, wkc)
            if reason is not Reason.NONE and self._words[at.HOLD_LIMIT]:
                self.stop(reason)
        elif self._mode == STOPPING and guard.advance(inputs, wkc):
            self._mode = STOPPED
            self._words[at.STATE] = STOPPED

    def _attend(self) -> None:
        """Look after everything but the cycle itself."""
        words = self._words
        if words[at.SILENCE]:
            self.leaving = True
            return
        if not self._look():
            self.end_when_stopped = True
            self.stop(Reason.RIG_GONE)
        if words[at.STOP_ORDER] > words[at.RESUMED]:
            self.stop(Reason.ORDERED)
        if self._mode == STOPPED:
            if self.end_when_stopped:
                self.leaving = True
            elif words[at.RESUME] > self._resumed:
                self._resume()

    def _resume(self) -> None:
        """The operator has acknowledged: follow set values again, from those not yet given."""
        words = self._words
        self._resumed = words[at.RESUME]
        if self.guard is not None:
            self.guard.clear()
        self._next, self._held, self._mode = max(self._next, words[at.SKIP_TO]), 0, CYCLING
        words[at.STOP_REASON] = Reason.NONE
        words[at.STATE] = CYCLING
        words[at.RESUMED] = self._resumed
