"""What a comparison came to: the simulation that was compared, the channels, the findings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from bench.mismatch.discovery import ChannelOutcome
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.report.finding import Finding
from bench.mismatch.report.left_out import LeftOut


@dataclass(frozen=True, slots=True)
class Compared:
    """The simulation that was compared: ``kind`` nominal, model, fmu, python or columns; its file; ids and symbols of
    what was calibrated anew on the recordings.
    """

    kind: str = "nominal"
    file: str | None = None
    recalibrated: tuple[str, ...] = ()


@dataclass(slots=True)
class Content:
    """What a report is made of. ``verdict``: match, mismatch or undetermined, ``why`` it is that last one.

    ``outcomes`` of the channels compared, ``skipped`` why others were not.
    """

    verdict: str
    why: str
    data: Dataset = field(repr=False)
    outcomes: Sequence[ChannelOutcome] = ()
    findings: Sequence[Finding] = ()
    skipped: Sequence[str] = ()
    left_out: Sequence[LeftOut] = ()
    simulation: Compared = Compared()
