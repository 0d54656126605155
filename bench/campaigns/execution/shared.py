"""What the parts of a run share: the bench, the folder, who listens, who may ask for a stop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from bench.campaigns.execution.outcome import end_of
from bench.campaigns.execution.sequence_call import call_sequence
from bench.campaigns.listener import Listener, Tap, Tapped
from bench.campaigns.operator.directions import Directions
from bench.configuration import BenchFile
from bench.cycle.end import End
from bench.cycle.rig import Rig
from bench.cycle.sink import Sink

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Shared:
    """``interrupted`` is asked between blocks, and so are the operator's ``directions``; ``tap`` sees every row."""

    rig: Rig
    file: BenchFile
    folder: Path
    listener: Listener
    directions: Directions
    tap: Tap | None
    interrupted: Callable[[], bool]

    def stop_requested(self) -> bool:
        """Whether the bench is to come to rest."""
        return self.interrupted() or self.directions.stop_requested

    def call(self, what: str, answer: Callable[[], T]) -> T:
        """Call code of a sequence while the bus goes on."""
        return call_sequence(what, answer, self.rig, self.stop_requested)

    def failed(self, error: Exception, sink: Sink | None = None) -> End:
        """Bring the bench to rest after a failure of the run itself; return the end it makes of the run."""
        return self.rig.trip(end_of(error), sink)

    def watched(self, sink: Sink, what: str) -> Sink:
        """Return a sink whose rows the tap sees as well; ``what`` names the motion to it."""
        if self.tap is None:
            return sink
        self.tap.begin(self.rig.scaling, self.rig.now, what)
        return Tapped(sink, self.tap, self.listener.noticed)
