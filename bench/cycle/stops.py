"""The stops of one rig: each run down the ladder, kept as a record, and latched unless the operator asked for it."""

from __future__ import annotations

from datetime import datetime
from typing import Protocol

from bench.cycle.end import End
from bench.cycle.sink import NoSink, Sink
from bench.cycle.stopping import Stop
from bench.safety import Cause, LatchFile, StopRecord


class Told(Protocol):
    """What is asked of a rig about a stop."""

    @property
    def now(self) -> datetime:
        """Time of day on the bench."""
        ...

    @property
    def drive_states(self) -> dict[str, str]:
        """State of each drive's state machine, by role."""
        ...


class Stops:
    """What a rig does with a stop.

    Attributes
    ----------
    latch : after a stop there is no torque until its three acts are done.
    records : the stops since the bench was opened, those that only switched the drives off left out.
    """

    def __init__(self, rig: Told, latch: LatchFile) -> None:
        self._rig = rig
        self.latch = latch
        self.records: list[StopRecord] = []

    def stop(self, end: End, sink: Sink, ladder: Stop) -> None:
        """Bring the bench to rest for the reason of ``end``; the latch holds before the first cycle of it."""
        if end.cause is not Cause.OPERATOR:
            self.latch.stopped(end.cause.name, end.text, self._rig.now)
        self.records.append(ladder.run(end.cause, sink, end.text))

    def lost(self, end: End) -> None:
        """Latch and keep a stop that nobody could lead: the bus is gone, the drives' watchdogs act."""
        if self.records and self.records[-1].text == end.text:
            return
        now = self._rig.now
        self.latch.stopped(end.cause.name, end.text, now)
        unseen = dict.fromkeys(self._rig.drive_states, "not seen")
        self.records.append(StopRecord(end.cause, end.text, now, -1, (), None, 0.0, 0.0, (), unseen))

    def switch_off(self, ladder: Stop) -> None:
        """Ramp down what still moves and take the voltage off: the end of a day, not a stop to be kept."""
        ladder.run(Cause.OPERATOR, NoSink())
