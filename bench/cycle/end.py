"""How a run of phases ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from bench.safety import Cause, is_device_fault

NOT_WRITTEN = "the recording cannot be written"
"""What is said first of a bench that was stopped because its recorder failed, as on a full disk."""


class EndKind(Enum):
    """How a run of phases ended."""

    FINISHED = "finished"
    EXPIRED = "a condition was not met in time"
    TRIPPED = "a limit stopped the bench"
    INTERRUPTED = "the operator stopped the bench"


@dataclass(frozen=True, slots=True)
class End:
    """How a run of phases ended, with the sentence for the operator."""

    kind: EndKind
    text: str = ""
    cause: Cause = Cause.NONE

    @property
    def headline(self) -> str:
        """What is said first of this end: what stopped the bench, by its cause."""
        text: str = self.kind.value
        if self.kind is not EndKind.TRIPPED:
            return text
        if self.cause is Cause.RECORDER:
            return NOT_WRITTEN
        if self.cause is Cause.PROGRAM:
            return "the run's own program failed"
        return "a device or the bus failed" if is_device_fault(self.cause) else text
