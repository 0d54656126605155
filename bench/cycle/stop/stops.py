"""The stops of one rig: each run down the ladder, kept as a record, and latched unless the operator asked for it."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from typing import Protocol

from bench.cycle.end import End
from bench.cycle.sink import NoSink, Sink
from bench.cycle.stop.climb import Stop
from bench.cycle.stop.coast_down import SHAFTS
from bench.safety import Cause, LatchFile, StopRecord


class RigState(Protocol):
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
    on_stop : is called with each of them.
    """

    def __init__(self, rig: RigState, latch: LatchFile) -> None:
        self._rig = rig
        self.latch = latch
        self.records: list[StopRecord] = []
        self.on_stop: Callable[[StopRecord], None] = lambda _: None

    def stop(self, end: End, sink: Sink, ladder: Stop) -> None:
        """Bring the bench to rest for the reason of ``end``; the latch holds before the first cycle of it.

        No file is waited for: other threads store the latch while the ladder sends its frames.
        """
        if end.cause is not Cause.OPERATOR:
            self.latch.stopped(end.cause.name, end.text, self._rig.now)
        self._keep(ladder.run(end.cause, sink, end.text))

    def unstored(self) -> str | None:
        """Return a sentence if the last stop could not be stored; asked when the bench is at rest."""
        return self.latch.settle()

    def lost(self, end: End) -> None:
        """Latch and keep a stop that nobody could lead: the bus is gone, and nothing is seen of the shafts."""
        if self.records and end.text.startswith(self.records[-1].text):
            return
        now = self._rig.now
        self.latch.stopped(end.cause.name, end.text, now)
        unseen = dict.fromkeys(self._rig.drive_states, "not seen")
        self._keep(StopRecord(end.cause, end.text, now, None, (), None, dict.fromkeys(SHAFTS), None, None, (), unseen))

    def _keep(self, record: StopRecord) -> None:
        self.records.append(record)
        self.on_stop(record)

    def switch_off(self, ladder: Stop) -> None:
        """Ramp down what still moves and take the voltage off: the end of a day, not a stop to be kept."""
        ladder.run(Cause.OPERATOR, NoSink())
