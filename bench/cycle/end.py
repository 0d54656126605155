"""How a run of phases ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from bench.safety import Cause


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
